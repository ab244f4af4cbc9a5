// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/least_squares.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

namespace soak::anfis {
namespace {

using Decomposition = Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;

// A D = (columns of unit norm); a column of zeros keeps its scale and is found to be dependent.
struct Scaled {
  Eigen::VectorXd scale;
  Decomposition decomposition;
};

Scaled decompose(const Eigen::Ref<const Eigen::MatrixXd>& a, double tolerance) {
  Scaled scaled;
  scaled.scale = a.colwise().norm().transpose();
  scaled.scale = (scaled.scale.array() > 0.0).select(scaled.scale.cwiseInverse(), 1.0);
  scaled.decomposition.setThreshold(tolerance);
  scaled.decomposition.compute(a * scaled.scale.asDiagonal());
  return scaled;
}

}  // namespace

LeastSquaresFit solve_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                    const Eigen::Ref<const Eigen::VectorXd>& b, double tolerance) {
  LeastSquaresFit fit;
  if (!a.allFinite() || !b.allFinite()) {
    fit.coefficients.setConstant(a.cols(), std::numeric_limits<double>::quiet_NaN());
    fit.residual_sum_of_squares = std::numeric_limits<double>::quiet_NaN();
    return fit;
  }
  const Scaled scaled = decompose(a, tolerance);
  const Decomposition& d = scaled.decomposition;
  fit.rank = d.rank();
  fit.coefficients = scaled.scale.asDiagonal() * d.solve(b);
  fit.residual_sum_of_squares = (a * fit.coefficients - b).squaredNorm();

  // A D P = Q [T 0; 0 0] Z, so (A D)^+ = P Z^T [T^-1 0; 0 0] Q^T and F = D P Z^T [T^-1; 0]
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(a.cols(), fit.rank);
  inverse.topRows(fit.rank) = d.matrixT()
                                  .topLeftCorner(fit.rank, fit.rank)
                                  .triangularView<Eigen::Upper>()
                                  .solve(Eigen::MatrixXd::Identity(fit.rank, fit.rank));
  if (fit.rank < a.cols()) {
    inverse = (d.matrixZ().transpose() * inverse).eval();
  }
  fit.covariance_factor = scaled.scale.asDiagonal() * (d.colsPermutation() * inverse);
  return fit;
}

Eigen::VectorXd least_squares_coefficients(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                           const Eigen::Ref<const Eigen::VectorXd>& b, double tolerance) {
  if (!a.allFinite() || !b.allFinite()) {
    return Eigen::VectorXd::Constant(a.cols(), std::numeric_limits<double>::quiet_NaN());
  }
  const Scaled scaled = decompose(a, tolerance);
  return scaled.scale.asDiagonal() * scaled.decomposition.solve(b);
}

}  // namespace soak::anfis
