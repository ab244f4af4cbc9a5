// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/noise/noise_components.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "calib/gap/noise/running_mean.h"

namespace soak::calib::gap {
namespace {

constexpr double kEnough = 10.0;  ///< degrees of freedom from which replicates say how visits scatter

/// Sum of squares about group means, pooled.
struct Pool {
  double squares = 0.0;
  double dof = 0.0;

  [[nodiscard]] double variance() const { return dof > 0.0 ? squares / dof : 0.0; }
};

/// A deviation of a part from its whole (a block from its placement...), and which of them are replicates.
struct Deviation {
  std::pair<int, int> replicate;
  double value;
};

/// `freedom`: share of the deviations within one whole that are free, as they sum to zero there.
Pool pool(const std::vector<Deviation>& deviations, double freedom) {
  std::map<std::pair<int, int>, Mean> means;
  for (const Deviation& d : deviations) means[d.replicate].add(d.value);
  Pool result;
  for (const Deviation& d : deviations) {
    const Mean& mean = means.at(d.replicate);
    if (mean.count < 2.0) continue;
    result.squares += (d.value - mean.value) * (d.value - mean.value);
    result.dof += (mean.count - 1.0) / mean.count * freedom;
  }
  return result;
}

/// The same without replicates: about zero.
Pool pool_of_one(const std::vector<Deviation>& deviations, double freedom) {
  Pool result;
  for (const Deviation& d : deviations) {
    result.squares += d.value * d.value;
    result.dof += freedom;
  }
  return result;
}

/// Means over placements, visits and runs, with what belongs to which.
struct Nest {
  std::map<int, Mean> placement;
  std::map<int, std::pair<int, int>> visit_of;  ///< placement → (run, visit)
  std::map<int, int> cell_of;
  std::map<std::pair<int, int>, Mean> visit;
  std::map<std::pair<int, int>, int> visit_cell;  ///< level and sweep, and how often before
  std::map<int, Mean> run;
};

Nest nest(const Observations& observations, const Eigen::VectorXd& residual) {
  Nest result;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const double value = residual(static_cast<Eigen::Index>(i));
    if (!std::isfinite(value)) continue;
    const Observation& row = observations.rows[i];
    result.placement[row.placement].add(value);
    result.visit_of[row.placement] = {row.run, row.visit};
    result.cell_of[row.placement] = row.cell;
  }
  for (const auto& [id, mean] : result.placement) result.visit[result.visit_of[id]].add(mean.value);
  for (const auto& [id, mean] : result.visit) result.run[id.first].add(mean.value);
  // The cell of a visit: that of its placement with the smallest number, whatever the order of the positions.
  for (const auto& [id, cell] : result.cell_of) {
    const auto visit = result.visit_of.at(id);
    const auto found = result.visit_cell.find(visit);
    if (found == result.visit_cell.end() || cell < found->second) result.visit_cell[visit] = cell;
  }
  return result;
}

double mean_count(const std::map<int, Mean>& means) {
  double sum = 0.0;
  for (const auto& [id, mean] : means) sum += mean.count;
  return means.empty() ? 1.0 : sum / static_cast<double>(means.size());
}

double mean_count(const std::map<std::pair<int, int>, Mean>& means) {
  double sum = 0.0;
  for (const auto& [id, mean] : means) sum += mean.count;
  return means.empty() ? 1.0 : sum / static_cast<double>(means.size());
}

}  // namespace

NoiseComponents noise_components(const Observations& observations, const Eigen::VectorXd& residual) {
  const Nest nested = nest(observations, residual);
  const double blocks = std::max(1.0, mean_count(nested.placement));
  const double placements = std::max(1.0, mean_count(nested.visit));
  const double visits = std::max(1.0, mean_count(nested.run));

  std::vector<Deviation> within_placement;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const double value = residual(static_cast<Eigen::Index>(i));
    if (!std::isfinite(value)) continue;
    const Observation& row = observations.rows[i];
    within_placement.push_back({{row.cell, row.block}, value - nested.placement.at(row.placement).value});
  }
  std::vector<Deviation> within_visit;
  for (const auto& [id, mean] : nested.placement) {
    const auto visit = nested.visit_of.at(id);
    within_visit.push_back({{nested.cell_of.at(id), 0}, mean.value - nested.visit.at(visit).value});
  }
  std::vector<Deviation> within_run;
  for (const auto& [id, mean] : nested.visit) {
    within_run.push_back({{nested.visit_cell.at(id), 0}, mean.value - nested.run.at(id.first).value});
  }

  Pool block = pool(within_placement, (blocks - 1.0) / blocks);
  Pool placement = pool(within_visit, (placements - 1.0) / placements);
  Pool visit = pool(within_run, (visits - 1.0) / visits);
  NoiseComponents noise;
  noise.replicated = visit.dof >= kEnough;
  if (!noise.replicated) {
    block = pool_of_one(within_placement, (blocks - 1.0) / blocks);
    placement = pool_of_one(within_visit, (placements - 1.0) / placements);
    visit = pool_of_one(within_run, (visits - 1.0) / visits);
  }
  noise.block_dof = block.dof;
  noise.placement_dof = placement.dof;
  noise.visit_dof = visit.dof;
  const double of_block = block.variance();
  const double of_placement = std::max(0.0, placement.variance() - of_block / blocks);
  const double of_visit = std::max(0.0, visit.variance() - (of_placement + of_block / blocks) / placements);
  noise.block = std::sqrt(of_block);
  noise.placement = std::sqrt(of_placement);
  noise.visit = std::sqrt(of_visit);
  return noise;
}

}  // namespace soak::calib::gap
