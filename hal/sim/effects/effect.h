// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/random.h"
#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/config/range.h"
#include "hal/sim/effects/conditions.h"

namespace soak::hal::sim {

/// One hidden effect of one unit. It is told the conditions moment by moment and keeps what it remembers of them;
/// then it says what it does to the sensors at that moment. An effect overrides only what it acts by.
class Effect {
 public:
  virtual ~Effect() = default;

  /// Goes on to `now`, the first call included; conditions change linearly in between.
  virtual void advance_to(const Conditions& now) = 0;

  /// Kelvin by which the sensing elements are warmer than the thermometer.
  [[nodiscard]] virtual double element_shift_c() const { return 0.0; }
  /// What is added to the reading of a sensor, per unit of its amplitude.
  [[nodiscard]] virtual double response(calib::Sensor) const { return 0.0; }
  /// What the noise of a sensor that is hit is multiplied by.
  [[nodiscard]] virtual double noise_factor() const { return 1.0; }
  /// What becomes of the output word of a sensor that is hit.
  [[nodiscard]] virtual double output(calib::Sensor, double value) const { return value; }
};

/// What an effect is made from.
struct EffectOrder {
  /// SI per unit of response; of a sensor that is not hit 0. Read by those that act on output words.
  std::array<double, calib::kSensorCount> gain{};
  /// In the unit of the effect: read by those that are not proportional to an amplitude.
  double amplitude = 0.0;
  std::uint64_t seed = 0;            ///< of everything that happens by chance while time passes
  std::optional<EarthFrame> earth;   ///< where the lab lies, if the configuration says so
  std::vector<double> set_points_c;  ///< of the campaign, or the ends of the range of temperature
};

/// One number that gives an effect its shape, as it was drawn; the name carries the unit.
struct ShapeParameter {
  std::string name;
  double value = 0.0;
};

/// Draws the shape of an effect and remembers it for the truth.
class ShapeDraws {
 public:
  explicit ShapeDraws(base::Random random) : random_(random) {}

  /// Uniform in `range`.
  [[nodiscard]] double within(std::string_view name, Range range) {
    return kept(name, random_.uniform(range.low, range.high));
  }
  /// As within(), the logarithm uniform: for time constants.
  [[nodiscard]] double spread(std::string_view name, Range range) {
    return kept(name, range.low * std::pow(range.high / range.low, random_.uniform()));
  }
  /// True with probability one half; 1 or 0 in the truth.
  [[nodiscard]] bool toss(std::string_view name) { return kept(name, random_.uniform() < 0.5 ? 1.0 : 0.0) > 0.5; }
  /// Remembers a number that was not drawn here.
  double kept(std::string_view name, double value) {
    parameters_.push_back({std::string(name), value});
    return value;
  }
  /// For what needs many numbers that no truth lists.
  [[nodiscard]] base::Random& random() { return random_; }
  [[nodiscard]] const std::vector<ShapeParameter>& parameters() const { return parameters_; }

 private:
  base::Random random_;
  std::vector<ShapeParameter> parameters_;
};

/// Makes an effect; draws its shape from `shape`.
using EffectMaker = std::unique_ptr<Effect> (*)(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
