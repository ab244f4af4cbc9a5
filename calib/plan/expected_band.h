// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "base/result.h"
#include "calib/plan/sensor_picture.h"
#include "calib/vocabulary/segment.h"

namespace soak::calib {

/// A visit to a plateau, in all positions.
struct PlannedVisit {
  double temp_c = 0.0;
  Sweep sweep = Sweep::unknown;  ///< the last change of temperature; unknown: where the branches of a loop meet

  bool operator==(const PlannedVisit&) const = default;
};

/// Power-ons that are planned alike: a run from switching on to switching off.
struct PlannedPowerOn {
  std::vector<PlannedVisit> visits;
  int count = 1;
};

/// A campaign as far as a bias curve depends on it.
struct CampaignDesign {
  std::vector<PlannedPowerOn> power_ons;
  double dwell_s = 600.0;  ///< in each position
};

/// What a design is expected to leave of one sensor's bias, SI. Bands are half-widths of 95 %.
struct ExpectedBand {
  std::vector<double> temp_c;
  std::vector<double> shape95;  ///< of the curve less its mean over temp_c: 1.96 standard deviations
  std::vector<double> curve95;  ///< of the mean curve, as a fit is expected to state it: √(shape95² + level95²)
  std::vector<double> fresh95;  ///< of one fresh power-on
  double level_sigma = 0.0;     ///< standard deviation of the curve's mean over temp_c
  double level95 = 0.0;         ///< level_sigma times Student's t with one degree of freedom less than power-ons

  [[nodiscard]] double worst_shape() const;
  [[nodiscard]] double worst_curve() const;
  [[nodiscard]] double worst_fresh() const;
};

/// Power-ons of a design.
[[nodiscard]] int count_power_ons(const CampaignDesign& design);

/// The error of the curve that the design leads to, which does not depend on the readings. A row is
///
///     y = level + f(T) + s h(T) + b + e,
///
/// f the picture's Gaussian process, h the half gap (the same correlations, scale half_gap; s = 1 heating, -1 cooling,
/// 0 where the run turns and both branches meet), b the offset of the power-on, of variance run_to_run², e of
/// visit_variance(). The level has no prior. The fit knows level, f and b, not h, which goes into the curve as far as
/// the directions do not cancel. With A the information of the rows about the values at the temperatures visited,
/// offsets integrated out, f = L u at these and u standard normal, level and u have the precision P = Hᵀ A H + diag(0,
/// I) [Rasmussen and Williams, eq. 2.11], h adds P⁻¹ Hᵀ A s h, and between the visits f has what they leave open
/// (eq. 2.24).
///
/// It assumes that the fit is as good as that posterior and that units are as the picture says: that offsets are the
/// same at all temperatures, that the unit settles, that curves have no feature that the picture does not know.
/// `temp_c`: where the bands are wanted. Needs a positive scale and a positive visit_variance(). Refuses (bad_input) a
/// design of fewer than two power-ons, which cannot tell the level of the next one, and an empty list of temperatures.
[[nodiscard]] base::Result<ExpectedBand> expected_band(const SensorPicture& picture, const CampaignDesign& design,
                                                       std::span<const double> temp_c);

}  // namespace soak::calib
