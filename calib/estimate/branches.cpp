// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/branches.h"

namespace soak::calib {

std::vector<Branch> find_branches(std::span<const double> temp_c, double reversal_c) {
  std::vector<Branch> branches;
  if (temp_c.empty()) return branches;
  Branch current;
  std::size_t lowest = 0;
  std::size_t highest = 0;
  const auto turn = [&](std::size_t at, Sweep next) {
    if (current.sweep != Sweep::unknown) {
      current.last = at;
      branches.push_back(current);
      current.first = at;
    }
    current.sweep = next;
  };
  for (std::size_t i = 0; i < temp_c.size(); ++i) {
    if (temp_c[i] < temp_c[lowest]) lowest = i;
    if (temp_c[i] > temp_c[highest]) highest = i;
    if (current.sweep != Sweep::up && temp_c[i] - temp_c[lowest] > reversal_c) {
      turn(lowest, Sweep::up);
      highest = i;
    } else if (current.sweep != Sweep::down && temp_c[highest] - temp_c[i] > reversal_c) {
      turn(highest, Sweep::down);
      lowest = i;
    }
  }
  current.last = temp_c.size();
  branches.push_back(current);
  return branches;
}

}  // namespace soak::calib
