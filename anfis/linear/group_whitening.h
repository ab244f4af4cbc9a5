// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

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

  void shrink(const Group& group, Eigen::Ref<Eigen::VectorXd> column) const;
  void shrink_groups(Eigen::Ref<Eigen::MatrixXd> values) const;

  Eigen::VectorXd root_weight_;
  std::vector<Group> groups_;  ///< in the order of first appearance; empty where nothing is to be shrunk
};

}  // namespace soak::anfis
