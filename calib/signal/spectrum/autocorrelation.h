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

/// Gauss-Markov process as a shaping filter's parameters [AH05 eq. 2.23-2.26].
struct GaussMarkov {
  double sigma = 0.0;          ///< standard deviation of the process, without white noise on top
  double correlation_s = 0.0;  ///< time at which the correlation falls to 1/e; first order: T; second: 2.1462/beta
  double beta_per_s = 0.0;     ///< first order: 1/T of sigma^2 exp(-t/T); second: of sigma^2 exp(-beta t)(1 + beta t)
  double white_sigma = 0.0;    ///< white noise per sample beside it, from the drop between lag 0 and 1
  double rms_misfit = 0.0;     ///< of the fitted correlation over the lags used
};

/// Least-squares fit of a rho(t), 0 <= a <= 1, to the correlation at the lags from 1 on (lag 0 holds the white noise)
/// to where it first falls below three tenths of that at lag 1, at least 3 lags; sigma^2 = a variance. From a record of
/// length L the time comes with a relative standard deviation near 1.5 sqrt(2 T/L), sigma with 0.5 sqrt(2 T/L); white
/// noise three times as large per sample doubles both. Refuses (bad_input) a rate that is not finite and positive,
/// fewer than 3 lags beside lag 0, a signal whose correlation is gone after one sample (rho_1 < 4/sqrt(n): white
/// noise), and lags too short to see it fall.
[[nodiscard]] base::Result<GaussMarkov> fit_gauss_markov_1(const Autocorrelation& acf, double rate_hz);
/// The second-order process [AH05 eq. 2.26, corrected: the exponent is -beta |t|].
[[nodiscard]] base::Result<GaussMarkov> fit_gauss_markov_2(const Autocorrelation& acf, double rate_hz);

}  // namespace soak::calib::signal
