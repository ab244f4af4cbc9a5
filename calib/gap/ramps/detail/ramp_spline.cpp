// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/ramp_spline.h"

#include <algorithm>
#include <cmath>

namespace soak::calib::gap::reduced {

Eigen::MatrixXd ramp_spline(const Eigen::VectorXd& temp_c, double low_c, double high_c, int intervals) {
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(temp_c.size(), intervals + 3);
  for (Eigen::Index i = 0; i < temp_c.size(); ++i) {
    const double place = std::clamp((temp_c(i) - low_c) / (high_c - low_c), 0.0, 1.0) * intervals;
    const int k = std::min(static_cast<int>(place), intervals - 1);
    const double u = place - k;
    // The four pieces of a cubic B-spline with knots at whole numbers.
    basis(i, k) = (1 - u) * (1 - u) * (1 - u) / 6;
    basis(i, k + 1) = (3 * u * u * u - 6 * u * u + 4) / 6;
    basis(i, k + 2) = (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6;
    basis(i, k + 3) = u * u * u / 6;
  }
  return basis;
}

}  // namespace soak::calib::gap::reduced
