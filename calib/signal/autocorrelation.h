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
  std::vector<double> correlation;  ///< at lags 0.. in samples, 1 at lag 0
  std::size_t samples = 0;          ///< that were present
};

/// Biased estimate (divided by n: positive definite) up to `longest` samples by fast transforms, O(n log n). NaN
/// samples are missing: products with them are left out of sum and count. Refuses infinite samples, fewer than 8
/// present ones, `longest` of 0 or not below the length, and a signal that does not vary.
[[nodiscard]] base::Result<Autocorrelation> autocorrelation(std::span<const double> samples, std::size_t longest);

/// First lag in s at which the correlation falls to 1/e [AH05 eq. 2.24], by straight interpolation; NaN: not within.
[[nodiscard]] double correlation_time_s(const Autocorrelation& acf, double rate_hz);

/// Gauss-Markov process as a shaping filter's parameters [AH05 eq. 2.23-2.26].
struct GaussMarkov {
  double sigma = 0.0;          ///< standard deviation of the process, without white noise on top
  double correlation_s = 0.0;  ///< first order: T of sigma^2 exp(-t/T); second: 2.146/beta, where it falls to 1/e
  double beta_per_s = 0.0;     ///< first: 1/T; second: of sigma^2 exp(-beta t)(1 + beta t)
  double white_sigma = 0.0;    ///< white noise per sample beside it, from the drop between lag 0 and 1
  double rms_misfit = 0.0;     ///< of the fitted correlation over the lags used
};

/// Least-squares fit to the correlation at the lags from 1 to where it first falls below 0.1 (at least 3 lags). Refuses
/// (bad_input) a signal whose correlation is gone after one sample: white noise.
[[nodiscard]] base::Result<GaussMarkov> fit_gauss_markov_1(const Autocorrelation& acf, double rate_hz);
[[nodiscard]] base::Result<GaussMarkov> fit_gauss_markov_2(const Autocorrelation& acf, double rate_hz);

}  // namespace soak::calib::signal
