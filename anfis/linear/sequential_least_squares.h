// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace soak::anfis {

/// Recursive least squares with forgetting: the sequential form of min sum_i lambda^(N-i) (b_i - a_i^T X)^2 [AH05
/// eq. 5.14; Astrom & Wittenmark 1984]. Each row (a, b) updates
///     S <- (S - S a a^T S / (lambda + a^T S a)) / lambda,    X <- X + S a (b - a^T X)    (S a with the new S)
/// from X = 0 and S = eta I. After N rows X is the minimum of that sum plus the prior (lambda^N / eta) ||X||^2, and
/// sigma^2 S its covariance where lambda = 1 and the rows' variance is sigma^2. The effective window is
/// 1/(1 - lambda) rows.
///
/// Use it where rows arrive one by one. The covariance form squares the condition of the problem: a batch belongs to
/// solve_least_squares().
///
/// Two rules keep it defined where the recursion alone is not:
///  - a row that is not finite, or whose update would overflow, is refused;
///  - wind-up: forgetting lets S grow along directions that no row excites. Where it has raised the variance S_jj of a
///    coefficient above 2 eta, the present value of that coefficient is taken for an observation that brings S_jj back
///    to eta: S <- S - S e_j e_j^T S (1 - eta/S_jj) / S_jj. X stays; S falls in every direction, in excited ones by a
///    share of S/eta; so no S_jj exceeds 2 eta after a row, and excited directions keep their window.
/// With lambda = 1 the recursion alone remains. Rows so large that rounding costs S its definiteness (|a|^2 eta above
/// about 1e16) leave the fit usable: the next rows restore it.
class SequentialLeastSquares {
 public:
  /// columns >= 1, initial_covariance (eta) > 0, forgetting (lambda) in (0, 1]; anything else is a bug of the caller.
  SequentialLeastSquares(std::size_t columns, double initial_covariance, double forgetting = 1.0);

  /// Takes the row (a, b). False, and nothing changes, where a or b is not finite or the update would overflow.
  /// Allocates no memory where `a` is contiguous.
  bool update(const Eigen::Ref<const Eigen::VectorXd>& a, double b);

  /// Begins anew with X = 0 and S = eta I. Allocates no memory.
  void restart();
  /// The same with X = coefficients.
  void restart(const Eigen::Ref<const Eigen::VectorXd>& coefficients);

  /// X
  [[nodiscard]] const Eigen::VectorXd& coefficients() const { return coefficients_; }
  /// S, exactly symmetric.
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }

 private:
  void restart_covariance();
  void limit_covariance();
  void subtract(double share);

  double initial_covariance_;
  double forgetting_;
  Eigen::VectorXd coefficients_;
  Eigen::MatrixXd covariance_;
  Eigen::VectorXd direction_;  ///< S a, or S e_j
  Eigen::VectorXd next_;       ///< coefficients after the row, until they are known to be finite
};

}  // namespace soak::anfis
