// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace soak::calib::gap {

/// Mean of what was added.
struct Mean {
  double count = 0.0;
  double value = 0.0;

  void add(double x) {
    count += 1.0;
    value += (x - value) / count;
  }
};

}  // namespace soak::calib::gap
