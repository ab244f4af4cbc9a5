// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anfis/select/detail/scaled_rows.h"

namespace soak::anfis::fuzzy {

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

}  // namespace soak::anfis::fuzzy
