// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/compaction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "anfis/linear/least_squares.h"
#include "base/linear/dense_solve.h"
#include "base/random.h"

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
  if (problem.y_squared == 0.0 || length <= kDependent * problem.squared_length(j)) return 0.0;
  const double projection = problem.columns.col(j).dot(problem.y);
  return projection / length * (projection / problem.y_squared);
}

// Takes the direction of column j out of all other columns.
void project_out(Orthogonalisation& problem, Eigen::Index j) {
  const Eigen::VectorXd w = problem.columns.col(j);
  const double length = w.squaredNorm();
  if (length <= kDependent * problem.squared_length(j)) return;
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

constexpr std::uint64_t kSplitStream = 0xE0;
constexpr std::size_t kLeastGroups = 4;

// Units (groups or rows) 0..count-1 that are held out.
std::vector<bool> drawn_units(std::size_t count, double share, std::uint64_t seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t unit) { return base::hashed(seed, kSplitStream, unit); });
  const auto wanted = static_cast<std::size_t>(std::lround(share * static_cast<double>(count)));
  std::vector<bool> drawn(count, false);
  for (std::size_t i = 0; i < std::clamp(wanted, std::size_t{1}, count - 1); ++i) drawn[order[i]] = true;
  return drawn;
}

std::vector<std::size_t> group_positions(const TrainingData& data) {
  const std::set<int> ids(data.group.begin(), data.group.end());
  std::vector<std::size_t> position;
  for (const int id : data.group) {
    position.push_back(static_cast<std::size_t>(std::distance(ids.begin(), ids.find(id))));
  }
  return position;
}

std::size_t group_count(const TrainingData& data) { return std::set<int>(data.group.begin(), data.group.end()).size(); }

}  // namespace

ClassCovariances class_covariances(const std::vector<Cluster>& clusters) {
  const Eigen::Index inputs = clusters.front().centre.size();
  // The corrected [AH05 eq. 5.37]: v_0 = sum_i p(eta_i) v_i; the print has no v_i. Priors sum to 1.
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(inputs);
  for (const Cluster& cluster : clusters) mean += cluster.prior * cluster.centre;
  ClassCovariances f{Eigen::MatrixXd::Zero(inputs, inputs), Eigen::VectorXd::Zero(inputs)};
  for (const Cluster& cluster : clusters) {
    f.between += cluster.prior * (cluster.centre - mean) * (cluster.centre - mean).transpose();
    f.within += cluster.prior * cluster.variance;
  }
  return f;
}

double log_separability(const ClassCovariances& covariances, const std::vector<int>& inputs) {
  const Eigen::VectorXd scale = covariances.within(inputs).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd total =
      Eigen::MatrixXd(scale.asDiagonal() * covariances.between(inputs, inputs) * scale.asDiagonal()) +
      Eigen::MatrixXd::Identity(scale.size(), scale.size());
  return 2.0 * base::cholesky(total).diagonal().array().log().sum();
}

std::vector<int> without(std::vector<int> inputs, int left_out) {
  std::erase(inputs, left_out);
  return inputs;
}

int least_needed(const ClassCovariances& covariances, const std::vector<int>& inputs) {
  int least = inputs.front();
  double most_left = -1.0;
  for (const int candidate : inputs) {
    if (const double left = log_separability(covariances, without(inputs, candidate)); left >= most_left) {
      most_left = left;
      least = candidate;
    }
  }
  return least;
}

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

Split split(const TrainingData& data, double share, std::uint64_t seed) {
  std::vector<bool> held_out(data.rows());
  if (const std::size_t groups = group_count(data); groups >= kLeastGroups) {
    const std::vector<bool> drawn = drawn_units(groups, share, seed);
    const std::vector<std::size_t> position = group_positions(data);
    std::transform(position.begin(), position.end(), held_out.begin(), [&](std::size_t group) { return drawn[group]; });
  } else {
    held_out = drawn_units(data.rows(), share, seed);
  }
  std::vector<bool> fit = held_out;
  fit.flip();
  return {select_rows(data, fit), select_rows(data, held_out)};
}

Eigen::VectorXd unit_errors(const TrainingData& data, const Model& model) {
  std::vector<double> r = residuals(data, model);
  Eigen::VectorXd squares = Eigen::Map<Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size()));
  const double variance = data.group_variance > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
  GroupWhitening(data.rows(), data.weight, data.group, variance).apply(squares);
  squares = squares.cwiseAbs2().eval();
  const std::size_t groups = group_count(data);
  if (groups < 2) return squares;
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(groups));
  const std::vector<std::size_t> position = group_positions(data);
  for (std::size_t k = 0; k < data.rows(); ++k) {
    sums(static_cast<Eigen::Index>(position[k])) += squares(static_cast<Eigen::Index>(k));
  }
  return sums;
}

Excess excess(const Eigen::VectorXd& errors, const Eigen::VectorXd& best) {
  const Eigen::VectorXd difference = errors - best;
  const auto units = static_cast<double>(difference.size());
  if (difference.size() < 2) {
    return {difference.sum(), 0.0};
  }
  const double variance = (difference.array() - difference.mean()).square().sum() / (units - 1.0);
  return {difference.sum(), std::sqrt(units * variance)};
}

std::size_t simplest_as_good(const std::vector<Eigen::VectorXd>& candidates) {
  const auto total = [](const Eigen::VectorXd& e) { return e.allFinite() ? e.sum() : HUGE_VAL; };
  const auto best = std::ranges::min_element(candidates, {}, total);
  const auto chosen = std::ranges::find_if(candidates, [&](const Eigen::VectorXd& errors) {
    if (&errors == &*best) return true;
    const Excess over_best = excess(errors, *best);
    return over_best.sum <= over_best.standard_error;
  });
  return static_cast<std::size_t>(chosen - candidates.begin());
}

}  // namespace soak::anfis::fuzzy
