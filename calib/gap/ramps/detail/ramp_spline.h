// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace soak::calib::gap::reduced {

/// Cubic B-splines on `intervals` equal intervals of low_c..high_c at the temperatures (one row each, intervals + 3
/// columns that sum to 1). Temperatures beyond the range count as its nearer end. Source: C. de Boor, A Practical Guide
/// to Splines, 2001, ch. X, for equal distances. Needs low_c < high_c, intervals > 0.
[[nodiscard]] Eigen::MatrixXd ramp_spline(const Eigen::VectorXd& temp_c, double low_c, double high_c, int intervals);

}  // namespace soak::calib::gap::reduced
