// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"

namespace soak::calib::signal {

/// Autocorrelation function of a signal whose mean is taken off.
struct Autocorrelation {
  double variance = 0.0;            ///< lag 0, U^2
  std::vector<double> correlation;  ///< at lags 0.. in samples, 1 at lag 0; NaN where no two samples are that far apart
  std::size_t samples = 0;          ///< that were present
};

/// Biased estimate (sum of the products divided by n: positive definite) up to `longest` samples by fast transforms,
/// O(n log longest), memory O(longest). NaN samples are missing: each lag's mean product is that of the pairs that are
/// there, times the same 1 - lag/n. The mean taken off is that of the signal itself: correlation that lasts a tenth of
/// the signal's length or more comes out too short. Refuses infinite samples, fewer than 8 present ones, `longest` of 0
/// or not below the length, and a signal that does not vary.
[[nodiscard]] base::Result<Autocorrelation> autocorrelation(std::span<const double> samples, std::size_t longest);

/// First lag in s at which the correlation falls to 1/e [AH05 eq. 2.24, corrected: sigma^2/e = 0.3679 sigma^2], by
/// straight interpolation; NaN: not within.
[[nodiscard]] double correlation_time_s(const Autocorrelation& acf, double rate_hz);

}  // namespace soak::calib::signal
