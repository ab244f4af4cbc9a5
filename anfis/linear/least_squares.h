// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace soak::anfis {

/// Solution of min ||A x - b||. Style of use: whiten A and b first (GroupWhitening), else covariances mean nothing.
struct LeastSquaresFit {
  Eigen::VectorXd coefficients;          ///< x; NaN where the problem held a value that is not finite
  Eigen::Index rank = 0;                 ///< numerical rank of A
  double residual_sum_of_squares = 0.0;  ///< ||A x - b||^2
  /// F with F F^T = (A^T A)^+, one row per coefficient and one column per rank. The variance of c^T x is
  /// sigma^2 ||F^T c||^2; where rank < columns that holds for functionals c in the row space of A only (estimable
  /// ones), as those outside it have no finite variance.
  Eigen::MatrixXd covariance_factor;

  [[nodiscard]] bool full_rank() const { return rank == coefficients.size(); }
};

/// Columns of A, scaled to unit norm, whose part that earlier pivots do not explain is below this share of the largest
/// pivot count as dependent. The rounding error of the factorisation is about 1e-16 times the number of columns; the
/// default leaves the two digits above it that NIST's Filip problem (degree 10, raw powers) needs.
inline constexpr double kRankTolerance = 1e-14;

/// Least squares by QR with column pivoting on columns scaled to unit norm; where A is rank-deficient, the solution of
/// least norm (in the scaled coefficients) from the complete orthogonal decomposition. A may have fewer rows than
/// columns.
[[nodiscard]] LeastSquaresFit solve_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                                  const Eigen::Ref<const Eigen::VectorXd>& b,
                                                  double tolerance = kRankTolerance);

/// The coefficients alone, for inner loops.
[[nodiscard]] Eigen::VectorXd least_squares_coefficients(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                                         const Eigen::Ref<const Eigen::VectorXd>& b,
                                                         double tolerance = kRankTolerance);

}  // namespace soak::anfis
