// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/least_squares.h"

#include <limits>

#include "base/linear/dense_solve.h"

namespace soak::anfis {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// D that gives the columns of A D unit norm; a column of zeros keeps its scale and is found to be dependent.
Eigen::VectorXd unit_norm_scale(const Eigen::Ref<const Eigen::MatrixXd>& a) {
  const Eigen::VectorXd norm = a.colwise().norm().transpose();
  return (norm.array() > 0.0).select(norm.cwiseInverse(), 1.0);
}

}  // namespace

LeastSquaresFit solve_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                    const Eigen::Ref<const Eigen::VectorXd>& b, double tolerance) {
  LeastSquaresFit fit;
  if (!a.allFinite() || !b.allFinite()) {
    fit.coefficients.setConstant(a.cols(), kNaN);
    fit.residual_sum_of_squares = kNaN;
    return fit;
  }
  const Eigen::VectorXd scale = unit_norm_scale(a);
  const auto solution = base::solve_orthogonal_with_factor(a * scale.asDiagonal(), b, tolerance);
  fit.rank = solution.rank;
  fit.coefficients = scale.asDiagonal() * solution.x;
  fit.residual_sum_of_squares = (a * fit.coefficients - b).squaredNorm();
  fit.covariance_factor = scale.asDiagonal() * solution.factor;
  return fit;
}

Eigen::VectorXd least_squares_coefficients(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                           const Eigen::Ref<const Eigen::VectorXd>& b, double tolerance) {
  if (!a.allFinite() || !b.allFinite()) return Eigen::VectorXd::Constant(a.cols(), kNaN);
  const Eigen::VectorXd scale = unit_norm_scale(a);
  const Eigen::VectorXd x = base::solve_orthogonal(a * scale.asDiagonal(), Eigen::VectorXd(b), tolerance);
  return scale.asDiagonal() * x;
}

}  // namespace soak::anfis
