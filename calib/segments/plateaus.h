// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace soak::calib {

/// A stretch of rows [first, last) in which the temperature stands still.
struct Plateau {
  std::size_t first = 0;
  std::size_t last = 0;
  double temp_c = 0.0;  ///< mean over the stretch
};

/// Finds the plateaus in a temperature history: longest stretches of at least 180 s in which ten-second means stay
/// within 0.6 K. Neighbouring stretches less than 1 K apart are one plateau; a chain of stretches that follow each
/// other without a step between is a slow ramp, not plateaus. `t_s` rises; NaN temperatures are passed over.
[[nodiscard]] std::vector<Plateau> find_plateaus(std::span<const double> t_s, std::span<const double> temp_c);

}  // namespace soak::calib
