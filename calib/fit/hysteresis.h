// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/calibration.h"
#include "calib/curve_data.h"

namespace soak::calib {

/// Difference between heating and cooling that a curve leaves.
struct SweepGap {
  double largest = 0.0;     ///< largest |up − down| over the temperatures visited both ways
  double at_temp_c = 0.0;   ///< where that is
  double noise = 0.0;       ///< standard error of one such difference
  double half_sigma = 0.0;  ///< half the difference, root mean square over the temperatures, less its noise
  double p_value = 1.0;     ///< of seeing such differences by noise alone (chi-squared)
};

/// Compares residuals of rows on the way up with those on the way down, bin by bin of temperature. The noise of a
/// difference is its scatter between runs, pooled over the bins, as slow noise within a run hides from the rows' own
/// standard errors; one run alone has nothing but those. Nothing where no temperature was visited both ways in the same
/// run.
[[nodiscard]] std::optional<SweepGap> find_sweep_gap(const CurveData& data, const Curve& curve);

}  // namespace soak::calib
