// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/group_deletion.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "anfis/linear/least_squares.h"
#include "anfis/select/detail/linearised.h"
#include "base/linear/dense_solve.h"

namespace soak::anfis {
namespace {

using Eigen::Index;

/// Keeps directions in which parameters move and the curve does not from having no step at all.
constexpr double kRidge = 1e-9;

/// The rows of one group, and where they stand among the condensed inputs.
struct GroupRows {
  std::vector<Index> at;
  Eigen::VectorXd weight;
  Eigen::VectorXd residual;
};

std::vector<GroupRows> split_groups(const Model& model, const CondensedRows& data) {
  const TrainingData& cells = data.by_group;
  const std::vector<double> r = residuals(cells, model);
  std::vector<GroupRows> groups;
  for (std::size_t first = 0; first < cells.rows();) {
    std::size_t last = first;
    while (last < cells.rows() && cells.group[last] == cells.group[first]) ++last;
    GroupRows rows;
    for (std::size_t i = first; i < last; ++i) {
      rows.at.push_back(std::lower_bound(data.rows.x.begin(), data.rows.x.end(), cells.x[i]) - data.rows.x.begin());
    }
    const auto size = static_cast<Index>(last - first);
    rows.weight = Eigen::Map<const Eigen::VectorXd>(cells.weight.data() + first, size);
    rows.residual = Eigen::Map<const Eigen::VectorXd>(r.data() + first, size);
    groups.push_back(std::move(rows));
    first = last;
  }
  return groups;
}

/// What one group says of the parameters: its part of J^T V^-1 J, and J_g^T V_g^-1 r_g.
struct GroupSays {
  Eigen::MatrixXd information;
  Eigen::VectorXd pull;
};

GroupSays says_of(const GroupRows& rows, const Eigen::MatrixXd& jacobian, double group_variance) {
  // V_g^-1 = W - share w w^T
  const double share = group_variance / (1.0 + group_variance * rows.weight.sum());
  const Eigen::MatrixXd own = jacobian(rows.at, Eigen::all);
  const Eigen::VectorXd level = own.transpose() * rows.weight;
  const Eigen::VectorXd weighted = rows.weight.cwiseProduct(rows.residual);
  return {own.transpose() * rows.weight.asDiagonal() * own - share * level * level.transpose(),
          own.transpose() * weighted - share * weighted.sum() * level};
}

double shape_error(const GroupRows& rows, const Eigen::VectorXd& residual) {
  const double weight = rows.weight.sum();
  const double mean = rows.weight.dot(residual) / weight;
  return std::sqrt(rows.weight.dot((residual.array() - mean).square().matrix()) / weight);
}

}  // namespace

base::Result<std::vector<double>> deleted_group_errors(const Model& model, const CondensedRows& data,
                                                       double smoothness) {
  if (auto status = validate_linearisation(model, data.rows, smoothness); !status) return base::forward_error(status);
  const std::vector<GroupRows> groups =
      data.by_group.group.empty() ? std::vector<GroupRows>() : split_groups(model, data);
  if (groups.size() < 2) return base::bad_input("one group cannot be judged by the others: give two or more", "group");

  const Eigen::MatrixXd j = jacobian(model, data.rows);
  const auto [whitened, price] = linearise(model, data.rows, smoothness, GroupWhitening(data.rows));
  Eigen::MatrixXd h = whitened.transpose() * whitened + price.transpose() * price;
  Eigen::VectorXd scale = h.diagonal().cwiseSqrt();
  scale = (scale.array() > kZeroColumn * scale.maxCoeff()).select(scale.cwiseInverse(), 0.0);
  h = scale.asDiagonal() * h * scale.asDiagonal();
  h.diagonal().array() += kRidge;
  const Eigen::MatrixXd scaled = j * scale.asDiagonal();

  std::vector<double> errors;
  for (const GroupRows& group : groups) {
    const GroupSays says = says_of(group, scaled, data.by_group.group_variance);
    const Eigen::VectorXd step = base::solve_ldlt(Eigen::MatrixXd(h - says.information), says.pull);
    errors.push_back(shape_error(group, group.residual + scaled(group.at, Eigen::all) * step));
  }
  return errors;
}

}  // namespace soak::anfis
