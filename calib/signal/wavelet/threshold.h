// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

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

}  // namespace soak::calib::signal
