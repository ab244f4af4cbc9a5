// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace soak::calib {

/// Difference between heating and cooling that a curve leaves.
struct SweepGap {
  double largest = 0.0;     ///< largest |up − down| over the temperatures visited both ways
  double at_temp_c = 0.0;   ///< where that is
  double noise = 0.0;       ///< standard error of one such difference
  double half_sigma = 0.0;  ///< half the difference, root mean square over the temperatures, less its noise
  double p_value = 1.0;     ///< of seeing such differences by noise alone (chi-squared)
};

}  // namespace soak::calib
