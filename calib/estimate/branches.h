// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/vocabulary/run.h"

namespace soak::calib {

/// A monotone piece [first, last) of a temperature history; `unknown` where the temperature never turned.
struct Branch {
  std::size_t first = 0;
  std::size_t last = 0;
  Sweep sweep = Sweep::unknown;
};

/// Cuts a temperature history at its turning points: extremes that it then leaves by more than `reversal_c`. Empty for
/// an empty history.
[[nodiscard]] std::vector<Branch> find_branches(std::span<const double> temp_c, double reversal_c);

}  // namespace soak::calib
