// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "base/result.h"
#include "calib/estimate/curve_data.h"

namespace soak::calib {

/// How often the curves of a sensor can be differentiated: covariance of Matérn's class of order 3/2 (kinks are near)
/// or 5/2 [Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, eq. 4.17].
enum class Smoothness : std::uint8_t { once, twice };

/// What is expected of a sensor's bias before a campaign of it has begun: a Gaussian process over temperature about an
/// unknown level, and what scatters about it. SI and °C; standard deviations.
struct SensorPicture {
  double scale = 0.0;     ///< of the curve about its level
  double length_c = 0.0;  ///< over which it bends, Matérn's l
  Smoothness smoothness = Smoothness::twice;
  double half_gap = 0.0;    ///< half the difference between heating and cooling, root mean square over temperatures
  double run_to_run = 0.0;  ///< of the level of a power-on
  double visit = 0.0;       ///< of a visit to a plateau: no dwell, only more visits average it
  double noise = 0.0;       ///< of a visit's bias from its samples, with `dwell_s` in each position
  double dwell_s = 600.0;

  /// Variance of the bias that a visit gives with so long a dwell: noise is white for shorter dwells than `dwell_s`; a
  /// longer one counts as no better, because slow noise does not average.
  [[nodiscard]] double visit_variance(double seconds) const;
};

/// Correlation of two points of a curve that lie so far apart.
[[nodiscard]] double correlation(const SensorPicture& picture, double apart_c);

/// The rows of one sensor of one unit, and the dwell in each position that they come from.
struct StoredCurve {
  CurveData data;
  double dwell_s = 600.0;
};

/// What the stored units of a type say together.
struct LearntPicture {
  SensorPicture picture;
  bool half_gap_known = false;    ///< some unit went both ways
  bool run_to_run_known = false;  ///< some unit has two power-ons
  int units = 0;
};

/// Scatter of the rows: mean squares over the units; that of visits is of rows of the same temperature and direction
/// where a unit has several runs, else all that a smooth curve leaves; that of power-ons is of rows without half the
/// gap of their temperature. Runs that stayed at one temperature show power-ons alone. Scale, length and smoothness:
/// those of the largest marginal likelihood of all units' mean curves, each with a level of its own that is integrated
/// out (Rasmussen and Williams, eq. 2.45), on a grid of steps of a quarter; lengths from 3 to 200 °C.
///
/// Mean curves are the rows less their run's offset about a smoothing spline, averaged per temperature (0.5 K) and
/// direction. The plateaus' spacing bounds what can be learnt: of a feature between them the units show nothing, and a
/// length of less than the spacing is not told from noise. Refuses (bad_input) where no unit has rows at plateaus that
/// make a curve.
[[nodiscard]] base::Result<LearntPicture> learn_picture(std::span<const StoredCurve> units);

}  // namespace soak::calib
