// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/six_position/problem.h"

namespace soak::calib::six_position {

/// Unknowns of one visit, in this order.
enum Local : int { kBias, kDrift, kScale, kLocalCount };

using LocalVector = Eigen::Matrix<double, kLocalCount, 1>;

/// What the joint fit says; variances are those of noise as large as the rows' weights say.
struct Solution {
  std::vector<LocalVector> local;
  std::vector<LocalVector> local_variance;  ///< diagonal of the covariance
  std::vector<bool> bias_known;
  Eigen::VectorXd shared;
  Eigen::VectorXd shared_variance;
  double reduced_chi_squared = 0.0;
};

/// Weighted least squares over all segments of the run, each visit's drift a random quantity of zero mean whose
/// variance is estimated from the run (expectation-maximisation). Cost linear in the number of segments.
[[nodiscard]] Solution solve(const Problem& problem);

}  // namespace soak::calib::six_position
