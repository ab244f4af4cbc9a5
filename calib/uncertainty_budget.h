// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace soak::calib {

/// One line of the uncertainty budget of a curve (JCGM 100:2008, 8): a standard uncertainty at each point of the curve.
struct Contribution {
  std::string name;  ///< "noise", "run_to_run", "hysteresis", "thermometer", "gravity", "fixture", "model"
  char type = 'A';   ///< 'A': from the scatter of these runs; 'B': from elsewhere
  std::optional<double> degrees_of_freedom;  ///< absent = infinite
  std::vector<double> u;                     ///< at the points of the curve, in its unit; empty = not stated
  bool in_ci95 = true;                       ///< part of the band of the mean curve
  bool in_pi95 = true;                       ///< part of the band of one fresh power-on
  std::string basis;                         ///< where the number comes from, or what is missing to state it
};

}  // namespace soak::calib
