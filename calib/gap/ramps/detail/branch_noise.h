// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace soak::calib::gap::reduced {

/// How the blocks of a sensor scatter about a curve of each branch's own.
struct BranchNoise {
  int intervals = 2;   ///< of the curve over the whole range (ramp_spline), the fewest that the criterion asks for
  double sigma = 0.0;  ///< of a block; 0 where the readings do not scatter
  double correlation = 0.0;  ///< of neighbouring blocks, 0 to 0.9
};

/// Fits a spline to every branch alone, so that what differs between branches is not taken for noise or for freedom of
/// the curve; among 2 to 10 intervals the Bayesian information criterion chooses. Rows in the order of time, `branch`
/// rising; at least 8 of them in some branch, the branches with fewer do not count.
[[nodiscard]] BranchNoise branch_noise(const Eigen::VectorXd& values, const Eigen::VectorXd& temp_c,
                                       const std::vector<int>& branch);

}  // namespace soak::calib::gap::reduced
