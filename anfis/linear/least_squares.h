// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "anfis/data/training_data.h"

namespace soak::anfis {

/// Whitening of rows that share a random offset per group (a run's own bias). With
///     V = diag(1/weight) + group_variance * (one block 1 1^T per group)
/// it applies L, L^T L = V^-1, so that generalised least squares on (A, y) is ordinary least squares on (L A, L y).
///
/// With u = sqrt(weight) of one group, V^-1 restricted to it is D (I + group_variance u u^T)^-1 D, D = diag(u)
/// (Sherman-Morrison), and L = (I - kappa u u^T / u^T u) D with kappa = 1 - 1/sqrt(1 + group_variance u^T u).
///
/// group_variance = +infinity means fixed effects: kappa = 1, each group's weighted mean is removed, and V^-1 is the
/// limit, of rank rows - groups. A constant column then whitens to zero.
class GroupWhitening {
 public:
  /// weight: 1/variance of each row, not negative (a group's sum positive), or empty for 1 everywhere; group: id of
  /// each row, or empty for no groups; group_variance >= 0 in the units of 1/weight. `rows` is the number of rows;
  /// sizes that disagree with it are a bug of the caller (validate data with validate(TrainingData)).
  GroupWhitening(std::size_t rows, std::span<const double> weight, std::span<const int> group, double group_variance);
  /// That of the data; of condensed rows L is their factor. `padded_rows`: filled up to so many with rows that weigh
  /// nothing (0: as many as there are).
  explicit GroupWhitening(const TrainingData& data, std::size_t padded_rows = 0);

  /// values <- L values, column by column.
  void apply(Eigen::Ref<Eigen::MatrixXd> values) const;
  /// values <- L^T values, column by column: apply_transposed(apply(r)) is V^-1 r.
  void apply_transposed(Eigen::Ref<Eigen::MatrixXd> values) const;

  [[nodiscard]] std::size_t rows() const { return static_cast<std::size_t>(root_weight_.size()); }
  /// Sum of the weights.
  [[nodiscard]] double total_weight() const { return root_weight_.squaredNorm(); }

 private:
  struct Group {
    std::vector<Eigen::Index> rows;
    bool contiguous = false;
    double factor = 0.0;  ///< kappa / (u^T u)
  };

  void apply_factor(Eigen::Ref<Eigen::MatrixXd> values) const;
  void apply_factor_transposed(Eigen::Ref<Eigen::MatrixXd> values) const;
  void shrink(const Group& group, Eigen::Ref<Eigen::VectorXd> column) const;
  void shrink_groups(Eigen::Ref<Eigen::MatrixXd> values) const;

  Eigen::VectorXd root_weight_;
  std::vector<Group> groups_;  ///< in the order of first appearance; empty where nothing is to be shrunk
  Eigen::MatrixXd factor_;     ///< of condensed rows, else empty
};

/// Solution of min ||A x - b||. Style of use: whiten A and b first (GroupWhitening), else covariances mean nothing.
struct LeastSquaresFit {
  Eigen::VectorXd coefficients;          ///< x; NaN where the problem held a value that is not finite
  Eigen::Index rank = 0;                 ///< numerical rank of A
  double residual_sum_of_squares = 0.0;  ///< ||A x - b||^2
  /// F with F F^T = (A^T A)^+, one row per coefficient and one column per rank. The variance of c^T x is
  /// sigma^2 ||F^T c||^2; where rank < columns that holds for functionals c in the row space of A only (estimable
  /// ones), as those outside it have no finite variance.
  Eigen::MatrixXd covariance_factor;
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
