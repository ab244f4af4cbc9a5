// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

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

}  // namespace soak::anfis::fuzzy
