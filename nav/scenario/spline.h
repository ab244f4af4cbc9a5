// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace soak::nav {

/// A smooth curve through knots that never leaves the range of the two knots beside it: piecewise cubic with the slopes
/// of Fritsch and Carlson (SIAM J. Numer. Anal. 17 (1980) 238), slope 0 at both ends. A stop stays a stop, a straight a
/// straight. The first derivative is continuous. Held beyond the ends.
class MonotoneSpline {
 public:
  /// At least 2 knots, times rising.
  MonotoneSpline(std::vector<double> t_s, std::vector<double> values);

  struct Point {
    double value = 0.0;
    double slope = 0.0;  ///< per second
  };
  [[nodiscard]] Point at(double t_s) const;

 private:
  std::vector<double> t_s_;
  std::vector<double> values_;
  std::vector<double> slopes_;
};

}  // namespace soak::nav
