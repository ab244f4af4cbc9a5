// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace soak::calib::signal {

/// How well a stretch of samples knows its own mean.
struct MeanError {
  double standard_error = 0.0;     ///< the larger of the two below
  double from_correlation = 0.0;   ///< from the estimated correlation
  double from_allan = 0.0;         ///< Allan deviation at the length of the stretch, extrapolated from within it
  double effective_samples = 0.0;  ///< variance / standard_error^2
};

/// Standard error of the mean of equally spaced samples (no NaN) under the correlation that they show, and never below
/// the Allan deviation at the length of the stretch: flicker and random walk do not average down. Both are estimated
/// from the stretch itself. 0 for fewer than 2 samples. O(n).
[[nodiscard]] MeanError standard_error_of_mean(std::span<const double> samples);

}  // namespace soak::calib::signal
