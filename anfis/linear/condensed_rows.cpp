// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/condensed_rows.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "base/linear/dense_solve.h"

namespace soak::anfis {
namespace {

using Eigen::Index;

double weight_of(const TrainingData& data, std::size_t row) { return data.weight.empty() ? 1.0 : data.weight[row]; }

/// Condensed row of each row, numbered upwards.
std::vector<std::size_t> rows_together(const TrainingData& data, double width) {
  std::vector<std::size_t> order(data.rows());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return data.x[a] < data.x[b]; });
  std::vector<std::size_t> together(data.rows());
  std::size_t current = 0;
  double lowest = data.x[order.front()];
  for (const std::size_t row : order) {
    if (data.x[row] > lowest && data.x[row] - lowest >= width) {
      lowest = data.x[row];
      ++current;
    }
    together[row] = current;
  }
  return together;
}

/// Condensed inputs: weighted means; and what their rows weigh together.
TrainingData condensed_inputs(const TrainingData& data, const std::vector<std::size_t>& together) {
  TrainingData condensed;
  const std::size_t count = *std::max_element(together.begin(), together.end()) + 1;
  condensed.x.assign(count, 0.0);
  condensed.weight.assign(count, 0.0);
  for (std::size_t i = 0; i < data.rows(); ++i) {
    const std::size_t k = together[i];
    if (condensed.weight[k] == 0.0) condensed.x[k] = data.x[i];
    condensed.weight[k] += weight_of(data, i);
    // From difference to difference: the mean of equal inputs is that input to the last bit.
    condensed.x[k] += (data.x[i] - condensed.x[k]) * (weight_of(data, i) / condensed.weight[k]);
  }
  condensed.rows_behind = data.rows();
  return condensed;
}

/// The rows of one group at one condensed input.
struct Cell {
  double weight = 0.0;
  double mean = 0.0;
};

/// group -> condensed input -> cell; the squares about the cells' means go to squares_within.
using Cells = std::map<int, std::map<std::size_t, Cell>>;

Cells fill_cells(const TrainingData& data, const std::vector<std::size_t>& together,
                 const std::function<double(double)>& shape, TrainingData& condensed) {
  std::vector<double> at_middle(condensed.rows());
  std::transform(condensed.x.begin(), condensed.x.end(), at_middle.begin(), shape);
  Cells cells;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    const std::size_t k = together[i];
    const double moved = data.x[i] == condensed.x[k] ? 0.0 : at_middle[k] - shape(data.x[i]);
    Cell& cell = cells[data.group.empty() ? 0 : data.group[i]][k];
    const double weight = weight_of(data, i);
    const double deviation = data.y[i] + moved - cell.mean;
    condensed.squares_within += deviation * deviation * cell.weight * weight / (cell.weight + weight);
    cell.weight += weight;
    cell.mean += deviation * weight / cell.weight;
  }
  return cells;
}

/// V^-1 of one group is diag(w) - share w w^T (Sherman-Morrison).
double share_of_offset(const std::map<std::size_t, Cell>& row, double group_variance) {
  double weight = 0.0;
  for (const auto& [k, cell] : row) weight += cell.weight;
  return group_variance / (1.0 + group_variance * weight);
}

/// G and P^T V^-1 y, summed over the groups.
struct NormalEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

NormalEquations normal_equations(const Cells& cells, double group_variance, std::size_t count) {
  const auto size = static_cast<Index>(count);
  NormalEquations sum{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
  Eigen::VectorXd weight(size);
  for (const auto& [group, row] : cells) {
    weight.setZero();
    double level = 0.0;
    for (const auto& [k, cell] : row) {
      weight(static_cast<Index>(k)) = cell.weight;
      sum.right(static_cast<Index>(k)) += cell.weight * cell.mean;
      level += cell.weight * cell.mean;
    }
    const double share = share_of_offset(row, group_variance);
    sum.matrix.diagonal() += weight;
    sum.matrix -= share * weight * weight.transpose();
    sum.right -= share * level * weight;
  }
  return sum;
}

/// The squares of the cells about the means m, (m_g - m)^T G_g (m_g - m) summed over the groups.
double squares_about(const Eigen::VectorXd& m, const Cells& cells, double group_variance) {
  double squares = 0.0;
  for (const auto& [group, row] : cells) {
    double level = 0.0;
    for (const auto& [k, cell] : row) {
      const double deviation = cell.mean - m(static_cast<Index>(k));
      squares += cell.weight * deviation * deviation;
      level += cell.weight * deviation;
    }
    squares -= share_of_offset(row, group_variance) * level * level;
  }
  return squares;
}

base::Status check(const TrainingData& data, double width) {
  if (auto status = validate(data, 0); !status) return status;
  if (data.inputs != 1) return base::bad_input("rows of several inputs cannot be condensed: give one input", "x");
  if (!data.precision_factor.empty()) return base::bad_input("the rows are condensed already", "precision_factor");
  if (std::isinf(data.group_variance)) {
    return base::bad_input(
        "free group offsets leave the level of condensed rows open: give an estimate of the variance",
        "group_variance");
  }
  if (!(width >= 0.0)) return base::bad_input("the width must be 0 or positive", "width");
  return {};
}

}  // namespace

base::Result<TrainingData> condense(const TrainingData& data, double width,
                                    const std::function<double(double)>& shape) {
  if (auto status = check(data, width); !status) return base::forward_error(status);
  const std::vector<std::size_t> together = rows_together(data, width);
  TrainingData condensed = condensed_inputs(data, together);
  const Cells cells = fill_cells(data, together, shape, condensed);
  const double variance = data.group.empty() ? 0.0 : data.group_variance;
  const NormalEquations sum = normal_equations(cells, variance, condensed.rows());
  const std::optional<Eigen::MatrixXd> lower = base::try_cholesky(sum.matrix);
  if (!lower) {
    return base::bad_input("the groups' offsets dwarf the noise of the rows: nothing is left of their level",
                           "group_variance");
  }
  const Eigen::MatrixXd factor = lower->transpose();
  const Eigen::VectorXd m = base::solve_upper(factor, base::solve_lower(*lower, sum.right));
  condensed.y.assign(m.data(), m.data() + m.size());
  condensed.squares_within += std::max(0.0, squares_about(m, cells, variance));
  condensed.precision_factor.assign(factor.data(), factor.data() + factor.size());
  return condensed;
}

}  // namespace soak::anfis
