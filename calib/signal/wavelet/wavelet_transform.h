// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace soak::calib::signal {

/// An orthogonal wavelet as the four filters of its two-channel bank, all of one even length F, in the order and with
/// the signs that PyWavelets uses: `dec_lo` is `rec_lo` reversed, `dec_hi[k] = (-1)^(k+1) rec_lo[k]`, `rec_hi` is
/// `dec_hi` reversed; the sum of `rec_lo` is sqrt(2).
struct Wavelet {
  std::string name;
  std::vector<double> dec_lo;
  std::vector<double> dec_hi;
  std::vector<double> rec_lo;
  std::vector<double> rec_hi;

  [[nodiscard]] std::size_t length() const { return dec_lo.size(); }
};

/// Daubechies' extremal-phase wavelets "db1" (Haar) to "db10" and her least asymmetric ones, "sym2" to "sym10"; N is
/// the number of vanishing moments, the filters have 2 N taps [Daubechies92]. The thesis uses db8 [AH05 §4.4]. The taps
/// are rounded from 60 digits; PyWavelets 1.1 has those of sym2 to sym8 to 4e-12 only. Refuses any other name
/// (bad_input, lists what there is).
[[nodiscard]] base::Result<Wavelet> wavelet_named(std::string_view name);

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
