// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/error_reduction.h"

#include <cstddef>
#include <utility>

namespace soak::anfis::fuzzy {
namespace {

// A column of which the earlier ones leave less than this share of its squared length depends on them: what is left is
// rounding (1e-16 times the number of columns, squared).
constexpr double kDependent = 1e-24;

struct Orthogonalisation {
  Eigen::MatrixXd columns;         ///< what earlier terms leave of each
  Eigen::VectorXd squared_length;  ///< of the columns at the start
  Eigen::VectorXd y;
  double y_squared = 0.0;
};

// rho_j = (w_j^T y)^2 / (w_j^T w_j y^T y)
double ratio(const Orthogonalisation& problem, Eigen::Index j) {
  const double length = problem.columns.col(j).squaredNorm();
  if (problem.y_squared == 0.0 || length <= kDependent * problem.squared_length(j)) {
    return 0.0;
  }
  const double projection = problem.columns.col(j).dot(problem.y);
  return projection / length * (projection / problem.y_squared);
}

// Takes the direction of column j out of all other columns.
void project_out(Orthogonalisation& problem, Eigen::Index j) {
  const Eigen::VectorXd w = problem.columns.col(j);
  const double length = w.squaredNorm();
  if (length <= kDependent * problem.squared_length(j)) {
    return;
  }
  problem.columns -= w * (w.transpose() * problem.columns / length);
}

Orthogonalisation weighted_columns(const ScaledRows& rows, const Eigen::Ref<const Eigen::VectorXd>& mu) {
  const Eigen::VectorXd root = mu.cwiseProduct(rows.weight).cwiseSqrt();
  Orthogonalisation problem;
  problem.columns.resize(rows.x.rows(), rows.x.cols() + 1);
  problem.columns << root.asDiagonal() * rows.x, root;
  problem.squared_length = problem.columns.colwise().squaredNorm().transpose();
  problem.y = root.cwiseProduct(rows.y);
  problem.y_squared = problem.y.squaredNorm();
  return problem;
}

}  // namespace

ErrorReduction error_reduction(const ScaledRows& rows, const Eigen::Ref<const Eigen::VectorXd>& mu) {
  Orthogonalisation problem = weighted_columns(rows, mu);
  const Eigen::Index inputs = rows.x.cols();
  ErrorReduction reduction;
  reduction.offset = ratio(problem, inputs);
  project_out(problem, inputs);
  std::vector<bool> taken(static_cast<std::size_t>(inputs), false);
  for (Eigen::Index term = 0; term < inputs; ++term) {
    std::pair<double, Eigen::Index> best{-1.0, 0};
    for (Eigen::Index j = 0; j < inputs; ++j) {
      if (!taken[static_cast<std::size_t>(j)] && ratio(problem, j) > best.first) {
        best = {ratio(problem, j), j};
      }
    }
    taken[static_cast<std::size_t>(best.second)] = true;
    reduction.order.push_back(static_cast<int>(best.second));
    reduction.ratios.push_back(best.first);
    project_out(problem, best.second);
  }
  return reduction;
}

std::size_t terms_kept(const ErrorReduction& reduction, double threshold) {
  const double allowed = threshold * (1.0 - reduction.offset);
  double tail = 0.0;
  std::size_t kept = reduction.ratios.size();
  while (kept > 0 && tail + reduction.ratios[kept - 1] < allowed) {
    tail += reduction.ratios[--kept];
  }
  return kept;
}

}  // namespace soak::anfis::fuzzy
