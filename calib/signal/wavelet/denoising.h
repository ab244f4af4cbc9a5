// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/signal/wavelet/wavelet_transform.h"

namespace soak::calib::signal {

/// What becomes of a detail coefficient d at threshold T. hard [AH05 eq. 4.11]: d where |d| > T, else 0. soft [AH05 eq.
/// 4.12, corrected]: sign(d)(|d| - T) where |d| > T, else 0. garrote (Gao 1998), continuous like soft, unbiased for
/// large d like hard: d - T^2/d where |d| > T, else 0.
enum class Shrinkage { none, soft, hard, garrote };

/// Applies the rule in place; T finite and >= 0. The instruction set is chosen at run time, the same bits on each.
void shrink(std::span<double> coefficients, double threshold, Shrinkage shrinkage);

/// Standard deviation of the noise by the median of the absolute finest-level details divided by 0.6745 [AH05 eq. 4.14,
/// corrected]; 0 for no coefficients. Up to half of them may be signal instead of noise. Where more than half are 0, as
/// with a reading that seldom changes its last digit, the answer is 0: there is no noise to be seen. O(n).
[[nodiscard]] double noise_level(std::span<const double> details);

/// Donoho and Johnstone's universal threshold sigma sqrt(2 ln n) [AH05 eq. 4.13], 0 for n <= 1. (n need not be whole:
/// eq. 4.15 has N/2^j.)
[[nodiscard]] double universal_threshold(double sigma, double n);

/// From which details the level of the noise is taken. finest: one sigma for all levels, right for white noise [AH05
/// eq. 4.14], and one threshold sigma sqrt(2 ln N) from the length of the signal [AH05 eq. 4.13]. per_level: sigma_j of
/// the level's own details and sigma_j sqrt(2 ln(N/2^j)), for coloured noise [AH05 eq. 4.15]; 0 at levels with
/// 2^j >= N, and weak on coarse levels, whose few details are mostly signal.
enum class NoiseFrom { finest, per_level };

/// How to denoise. The threshold of level j (1 is the finest) is lambda_j times the one that `noise` or `threshold`
/// says; lambda_j = 0 leaves the level as it is.
struct DenoisingOptions {
  std::size_t levels = 6;
  Boundary boundary = Boundary::symmetric;
  Shrinkage shrinkage = Shrinkage::soft;
  NoiseFrom noise = NoiseFrom::finest;
  /// Relaxation factor lambda_j of each level's threshold, finest first [AH05 eq. 4.15]; levels beyond the end have 1.
  std::vector<double> relaxation;
  /// One threshold for all levels (still times the relaxation factor) instead of the universal one.
  std::optional<double> threshold;
};

/// A signal split by wavelet multi-resolution analysis; signal and trend have the length of the samples.
struct Denoised {
  std::vector<double> signal;  ///< from the approximation and the shrunk details
  std::vector<double> trend;   ///< from the approximation alone: what is slower than 2^levels samples [AH05 fig. 6.1]
  std::vector<double> thresholds;  ///< that of each level, finest first
  std::vector<double> sigma;       ///< noise level found in the details of each level, finest first
};

/// Splits the signal into trend, signal and noise. Refuses what decompose() refuses, a threshold or factor that is
/// negative or not finite, and more factors than levels. O(n F).
[[nodiscard]] base::Result<Denoised> denoise(std::span<const double> samples, const Wavelet& wavelet,
                                             const DenoisingOptions& options);

}  // namespace soak::calib::signal
