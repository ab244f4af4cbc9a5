// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/estimate/detail/problem.h"

namespace soak::calib::six_position {

/// Unknowns of one visit, in this order.
enum Local : int { kBias, kDrift, kScale, kLocalCount };

using LocalVector = Eigen::Matrix<double, kLocalCount, 1>;

/// What the joint fit says; variances are those of noise as large as the rows' weights say.
struct Solution {
  std::vector<LocalVector> local;
  std::vector<LocalVector> local_variance;  ///< diagonal of the covariance
  std::vector<bool> bias_known;
  std::vector<bool> scale_known;
  Eigen::VectorXd shared;
  Eigen::MatrixXd shared_covariance;
  Eigen::MatrixXd open;         ///< one column per direction of `shared` that the segments do not show
  double drift_variance = 0.0;  ///< of the visits' drifts, estimated
  double reduced_chi_squared = 0.0;
};

/// Normal equations of the shared unknowns, those of the visits eliminated: matrix · shared = right.
struct SharedNormal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

/// Index of the even-order term among the shared unknowns, K₂·g².
inline constexpr Eigen::Index kEven = 2;
/// The last unknowns of a problem with_level: tilts of the vertical to north and east, times g.
inline constexpr int kLevelCount = 2;

/// Whether the segments show the combination `weights`·shared.
[[nodiscard]] bool shows(const Solution& solution, const Eigen::VectorXd& weights);

/// Weighted least squares over all segments of the run, each visit's drift a random quantity of zero mean whose
/// variance is estimated from the run (expectation-maximisation). Cost linear in the number of segments.
[[nodiscard]] Solution solve(const Problem& problem);

/// The shared unknowns' part of the same fit, drifts of that variance; `right` is linear in the rows' values.
[[nodiscard]] SharedNormal shared_normal(const Problem& problem, double drift_variance);

/// What standard errors are multiplied by: residuals larger than the segments' own errors promise inflate them; where
/// those are not known, the residuals alone are the measure.
[[nodiscard]] double inflation_of(const Problem& problem, const Solution& solution);

}  // namespace soak::calib::six_position
