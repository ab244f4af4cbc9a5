// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/select/detail/gath_geva.h"
#include "anfis/select/fuzzy_clustering.h"

namespace soak::anfis::fuzzy {

/// Covariances of a partition [AH05 eq. 5.37], inputs x inputs, in scaled units.
struct ClassCovariances {
  Eigen::MatrixXd between;  ///< F_B = sum_i p(eta_i) (v_i - v_0)(v_i - v_0)^T, v_0 = sum_i p(eta_i) v_i
  Eigen::VectorXd within;   ///< diagonal of F_W = sum_i p(eta_i) F_i, F_i = diag(sigma_i1^2, sigma_i2^2, ..)
};
[[nodiscard]] ClassCovariances class_covariances(const std::vector<Cluster>& clusters);

/// Fisher's interclass separability of some inputs,
///     log J = log det(F_B + F_W) - log det(F_W) = log det(I + F_W^-1/2 F_B F_W^-1/2) >= 0.
/// [AH05 eq. 5.38] has det(F_B) alone above the line. That is 0 whatever the data as soon as there are not more
/// clusters than inputs (the rank of F_B is at most clusters - 1), and it falls when an input with less between than
/// within variance joins, so that subsets of different size cannot be compared. The sum F_B + F_W = F_T is the total
/// covariance; J is then the inverse of Wilks' lambda, which ranks as eq. 5.38 does where clusters lie far apart, never
/// falls when an input joins, and counts an input whose centres repeat those of another only for what it adds.
[[nodiscard]] double log_separability(const ClassCovariances& covariances, const std::vector<int>& inputs);

/// The input whose absence leaves the largest separability to the others; the last one among equals.
[[nodiscard]] int least_needed(const ClassCovariances& covariances, const std::vector<int>& inputs);

/// `inputs` without one of them.
[[nodiscard]] std::vector<int> without(std::vector<int> inputs, int left_out);

/// What each consequent term of one rule explains of the weighted output.
struct ErrorReduction {
  double offset = 0.0;         ///< rho of the unit column, which is always taken first
  std::vector<int> order;      ///< inputs by falling error reduction, each after those before it
  std::vector<double> ratios;  ///< rho of order[0], order[1].. : their sum with offset is at most 1
};

/// Orthogonal least squares with forward selection [AH05 eq. 5.35-5.36; Chen, Billings & Luo 1989]. The columns of
/// B = sqrt(beta) [phi 1], beta = diag(mu_k weight_k), are made orthogonal one after the other (modified Gram-Schmidt),
/// the unit column first, then always the one with the largest
///     rho_j = g_j^2 w_j^T w_j / (y^T beta y),   g_j = w_j^T sqrt(beta) y / w_j^T w_j.
/// The print has W^T W = I beside g_j^2 w_j^T w_j: W has orthogonal columns of any length; and A is unit upper
/// triangular. A column that depends on those before it, and every column where y is 0, has rho 0; equals keep the
/// order of inputs.
[[nodiscard]] ErrorReduction error_reduction(const ScaledRows& rows, const Eigen::Ref<const Eigen::VectorXd>& mu);

/// Terms at the end of the order which together explain less than `threshold` of what the offset leaves, y^T beta y (1
/// - rho_offset): number of terms to keep.
[[nodiscard]] std::size_t terms_kept(const ErrorReduction& reduction, double threshold);

/// Rows to fit on, and the others to judge by.
struct Split {
  TrainingData fit;
  TrainingData held_out;
};

/// Holds out a share of the groups, drawn by the seed, or where there are fewer than four of them a share of the rows.
/// At least one is held out and one stays. Needs two rows.
[[nodiscard]] Split split(const TrainingData& data, double share, std::uint64_t seed);

/// Weighted squared errors of a model, summed over each group, or where there are fewer than two of them row by row.
/// Where group_variance is positive each group's own weighted mean is taken out of the residuals first, as in
/// shape_rmse().
[[nodiscard]] Eigen::VectorXd unit_errors(const TrainingData& data, const Model& model);

/// How much worse one candidate is than another on the same units: the sum of differences and its standard error.
struct Excess {
  double sum = 0.0;
  double standard_error = 0.0;
};
[[nodiscard]] Excess excess(const Eigen::VectorXd& errors, const Eigen::VectorXd& best);

/// The one-standard-error rule on paired differences: the first candidate (simplest first) whose excess over the best
/// is at most one standard error.
[[nodiscard]] std::size_t simplest_as_good(const std::vector<Eigen::VectorXd>& candidates);

}  // namespace soak::anfis::fuzzy
