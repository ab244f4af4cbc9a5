// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/signal/wavelet/wavelet.h"

namespace soak::calib::signal {

/// How the signal goes on beyond its ends. symmetric: mirrored at the half sample (..x1 x0 | x0 x1..), coefficients of
/// a level number floor((n + F - 1)/2). periodization: the signal repeats (an odd one with its last sample doubled),
/// ceil(n/2) coefficients, and the transform is orthogonal. Both as PyWavelets has them, coefficient by coefficient.
enum class Boundary { symmetric, periodization };

/// Coefficients of a signal at several levels [AH05 eq. 4.3-4.10].
struct Decomposition {
  std::size_t samples = 0;  ///< length of the signal
  Boundary boundary = Boundary::symmetric;
  std::vector<double> approximation;         ///< of the coarsest level
  std::vector<std::vector<double>> details;  ///< details[0] is the finest level, details[L - 1] the coarsest
  std::vector<double> workspace;             ///< of decompose(), means nothing afterwards

  [[nodiscard]] std::size_t levels() const { return details.size(); }
};

/// Deepest level at which a coefficient still sees more signal than boundary: floor(log2(n/(F - 1))), at least 0.
[[nodiscard]] std::size_t useful_levels(std::size_t samples, const Wavelet& wavelet);

/// Decomposes into `levels` levels (any depth from 1 to 40; beyond useful_levels() the boundary dominates). `into` is
/// overwritten; its memory is used again, so that a second call with the same sizes allocates nothing.
/// Refuses an empty signal, a value that is not finite (naming its index), a depth outside 1..40, and a wavelet whose
/// four filters are not of one even length from 2 to 20. O(n F), the instruction set chosen at run time, the same bits
/// on each.
[[nodiscard]] base::Status decompose(std::span<const double> signal, const Wavelet& wavelet, std::size_t levels,
                                     Boundary boundary, Decomposition& into);

/// The signal that the coefficients stand for: `decomposition.samples` values written to `signal`, which must have that
/// length. `scratch` is working memory, used again by the next call. Coefficients may have been changed, their numbers
/// must be those that decompose() gave (else bad_input). The wavelet as for decompose().
[[nodiscard]] base::Status reconstruct(const Decomposition& decomposition, const Wavelet& wavelet,
                                       std::vector<double>& scratch, std::span<double> signal);

}  // namespace soak::calib::signal
