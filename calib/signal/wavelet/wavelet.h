// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace soak::calib::signal
