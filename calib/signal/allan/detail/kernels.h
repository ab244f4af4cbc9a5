// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace soak::calib::signal::allan {

// Sums of squares over `starts` neighbouring beginnings at one multiple m >= 1 of the sample interval. The order of the
// additions depends on nothing but m and `starts`: 16 (modified: 8) interleaved partial sums, then a tree. The
// instruction set is chosen at run time, the same bits on each.
//
// Digits, with u = 2^-53: a phase point x carries an error of u|x| from its own rounding, so a second difference is
// known to within 4u max|x|, a third to within 8u max|x|, and no order of operations wins these back. Neighbours are
// subtracted first, so that the subtractions themselves only add 4u D (12u D), D the largest |x[i+m] - x[i]|.

/// Sum over i < starts of (x[i+2m] - 2x[i+m] + x[i])^2. Reads starts + 2m points.
[[nodiscard]] double second_differences(const double* x, std::size_t m, std::size_t starts);

/// Sum over i < starts of (x[i+3m] - 3x[i+2m] + 3x[i+m] - x[i])^2. Reads starts + 3m points.
[[nodiscard]] double third_differences(const double* x, std::size_t m, std::size_t starts);

/// Sum over i < starts of S_i^2, S_i = sum over i <= j < i+m of (x[j+2m] - 2x[j+m] + x[j]). Reads starts + 3m - 1
/// points; O(starts + m).
///
/// S_0 is added up, the others follow by eights: S_{i+8} = S_i + W_i, W_i = T_i + .. + T_{i+7}, where T_i is the third
/// difference at i. Each S_i is thus the end of a chain of at most starts/8 additions; S_0 is wrong by at most
/// u m (m/8 + 12) D, a step W by 8 * 12u D and three levels of additions of at most 32D, together 192u D:
///   |error of S| <= u (starts/8) (max|S| + 192 D) + u m (m/8 + 12) D
/// beyond what the phase itself carries; it does not grow with the length of the record. (Signs are random: in practice
/// the root of these counts.) Were the cumulative sum of the phase kept over all N points instead, its error of about
/// u N max|x| would swamp S wherever the phase walks far away.
[[nodiscard]] double modified_differences(const double* x, std::size_t m, std::size_t starts);

}  // namespace soak::calib::signal::allan
