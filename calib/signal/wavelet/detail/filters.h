// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

namespace soak::calib::signal::wavelet {

/// The low-pass filter of reconstruction, from which the three others follow.
struct NamedFilter {
  std::string_view name;
  std::span<const double> rec_lo;
};

/// All wavelets there are, "db1" to "db10", then "sym2" to "sym10".
[[nodiscard]] std::span<const NamedFilter> filters();

}  // namespace soak::calib::signal::wavelet
