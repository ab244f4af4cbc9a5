// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/group_whitening.h"

#include <cassert>
#include <cmath>
#include <map>

namespace soak::anfis {

GroupWhitening::GroupWhitening(std::size_t rows, std::span<const double> weight, std::span<const int> group,
                               double group_variance)
    : root_weight_(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(rows))) {
  assert(weight.empty() || weight.size() == rows);
  assert(group.empty() || group.size() == rows);
  assert(group_variance >= 0.0);
  for (std::size_t i = 0; i < weight.size(); ++i) {
    root_weight_(static_cast<Eigen::Index>(i)) = std::sqrt(weight[i]);
  }
  if (group.empty() || group_variance == 0.0) {
    return;
  }
  std::map<int, std::size_t> position;
  for (std::size_t i = 0; i < rows; ++i) {
    const auto found = position.try_emplace(group[i], groups_.size());
    if (found.second) {
      groups_.emplace_back();
    }
    groups_[found.first->second].rows.push_back(static_cast<Eigen::Index>(i));
  }
  for (Group& g : groups_) {
    double norm = 0.0;  // u^T u
    for (const Eigen::Index row : g.rows) {
      norm += root_weight_(row) * root_weight_(row);
    }
    g.contiguous = g.rows.back() - g.rows.front() + 1 == static_cast<Eigen::Index>(g.rows.size());
    g.factor = (1.0 - 1.0 / std::sqrt(1.0 + group_variance * norm)) / norm;
  }
}

void GroupWhitening::apply(Eigen::Ref<Eigen::MatrixXd> values) const {
  values.array().colwise() *= root_weight_.array();
  shrink_groups(values);
}

void GroupWhitening::apply_transposed(Eigen::Ref<Eigen::MatrixXd> values) const {
  shrink_groups(values);
  values.array().colwise() *= root_weight_.array();
}

// z <- z - kappa u (u^T z) / (u^T u)
void GroupWhitening::shrink(const Group& group, Eigen::Ref<Eigen::VectorXd> column) const {
  if (group.contiguous) {
    const auto u = root_weight_.segment(group.rows.front(), static_cast<Eigen::Index>(group.rows.size()));
    auto z = column.segment(group.rows.front(), u.size());
    const double projection = u.dot(z);
    z -= (group.factor * projection) * u;
    return;
  }
  double projection = 0.0;
  for (const Eigen::Index row : group.rows) projection += root_weight_(row) * column(row);
  for (const Eigen::Index row : group.rows) column(row) -= group.factor * projection * root_weight_(row);
}

void GroupWhitening::shrink_groups(Eigen::Ref<Eigen::MatrixXd> values) const {
  for (Eigen::Index column = 0; column < values.cols(); ++column) {
    for (const Group& group : groups_) shrink(group, values.col(column));
  }
}

}  // namespace soak::anfis
