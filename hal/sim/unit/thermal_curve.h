// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "base/random.h"
#include "hal/sim/config/campaign_config.h"

namespace soak::hal::sim {

/// How one quantity of a made-up sensor depends on temperature, in closed form:
///
///   y(T) = y₀ + Σ aᵢ atan((T − cᵢ)/wᵢ) + a exp(−E/k · (1/T_K − 1/T_hot)) + Σ hⱼ exp(−(T − tⱼ)²/2sⱼ²)
///
/// The default curve is zero everywhere. Defined at every temperature above absolute zero.
class ThermalCurve {
 public:
  struct Arctan {
    double gain = 0.0;
    double centre_c = 0.0;
    double width_c = 1.0;
  };
  struct Activated {
    double gain = 0.0;  ///< value at the hot end
    double energy_ev = 0.0;
    double hot_c = 0.0;
  };
  struct Feature {
    double height = 0.0;
    double centre_c = 0.0;
    double sigma_c = 1.0;
  };

  [[nodiscard]] double at(double temp_c) const { return offset_ + smooth(temp_c) + local(temp_c); }
  [[nodiscard]] const std::vector<Feature>& features() const { return features_; }

  /// A curve of the given shape and magnitudes. Its span over `shape.cold_c` ... `shape.hot_c`, as span_of() counts it,
  /// is uniform in `magnitudes.span`. Takes uniform numbers only from `random`.
  [[nodiscard]] static ThermalCurve draw(const CurveShape& shape, const CurveMagnitudes& magnitudes,
                                         base::Random& random);

 private:
  [[nodiscard]] double smooth(double temp_c) const;
  [[nodiscard]] double local(double temp_c) const;
  void scale_smooth_to_span(const CurveShape& shape, double span);

  double offset_ = 0.0;
  std::array<Arctan, 2> arctans_;
  Activated activated_;
  std::vector<Feature> features_;
};

/// Temperatures from `shape.cold_c` to `shape.hot_c`, one each 0.25 °C.
[[nodiscard]] std::vector<double> dense_grid_c(const CurveShape& shape);

/// Largest minus smallest value.
[[nodiscard]] double span_of(const std::vector<double>& values);

}  // namespace soak::hal::sim
