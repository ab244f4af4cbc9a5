// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/observations/detail/cell_means.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/statistics.h"
#include "calib/gap/noise/running_mean.h"

namespace soak::calib::gap {
namespace {

/// Plateaus visited twice from which their differences say how visits scatter; below it, blocks stand in: visits of
/// real units scatter more than those do.
constexpr double kEnough = 4.0;
constexpr double kVisitsToBlocks = 4.0;

/// Values by group.
using Groups = std::map<int, std::vector<double>>;

double mean_of(const std::vector<double>& values) {
  Mean mean;
  for (const double value : values) mean.add(value);
  return mean.value;
}

}  // namespace

CellMeans::CellMeans(const Observations& observations, const Eigen::VectorXd& values)
    : levels_(observations.level_count()) {
  std::vector<std::map<int, Mean>> means(observations.runs.size());
  std::map<int, std::vector<double>> placements;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const Observation& row = observations.rows[i];
    const double value = values(static_cast<Eigen::Index>(i));
    const auto cell = static_cast<std::size_t>(row.cell);
    if (cell >= cells_.size()) cells_.resize(cell + 1);
    cells_[cell] = {row.level, row.position};
    if (!std::isfinite(value)) continue;
    means[static_cast<std::size_t>(row.run)][row.cell].add(value);
    placements[row.placement].push_back(value);
  }
  for (const auto& of_run : means) {
    std::vector<double>& row = means_.emplace_back(cells_.size(), std::numeric_limits<double>::quiet_NaN());
    for (const auto& [cell, mean] : of_run) row[static_cast<std::size_t>(cell)] = mean.value;
  }
  double squares = 0.0;
  double dof = 0.0;
  for (const auto& [id, blocks] : placements) {
    const double mean = mean_of(blocks);
    for (const double value : blocks) squares += (value - mean) * (value - mean);
    dof += static_cast<double>(blocks.size()) - 1.0;
  }
  if (dof > 0.0) block_variance_ = squares / dof;
}

std::optional<double> CellMeans::distance(int run, int other) const {
  const std::vector<double>& a = means_[static_cast<std::size_t>(run)];
  const std::vector<double>& b = means_[static_cast<std::size_t>(other)];
  Groups by_position;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const double difference = a[c] - b[c];
    if (std::isfinite(difference)) by_position[cells_[c].position].push_back(difference);
  }
  std::map<int, double> middle;
  for (const auto& [position, differences] : by_position) middle[position] = base::median(differences);
  Groups by_level;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const double difference = a[c] - b[c];
    if (std::isfinite(difference)) by_level[cells_[c].level].push_back(difference - middle.at(cells_[c].position));
  }
  if (by_level.size() < 2) return std::nullopt;
  std::vector<double> shape;
  for (const auto& [level, differences] : by_level) shape.push_back(base::median(differences));
  const double mean = mean_of(shape);
  double squares = 0.0;
  for (const double value : shape) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(shape.size()));
}

double CellMeans::scatter() const {
  Mean squares;
  for (const std::vector<double>& run : means_) {
    // Of each plateau, what each position read visit after visit.
    std::vector<std::map<int, std::vector<double>>> levels(static_cast<std::size_t>(levels_));
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      if (!std::isfinite(run[c])) continue;
      levels[static_cast<std::size_t>(cells_[c].level)][cells_[c].position].push_back(run[c]);
    }
    for (const auto& positions : levels) {
      std::vector<double> differences;
      for (const auto& [position, visits] : positions) {
        if (visits.size() > 1) differences.push_back(visits.back() - visits.front());
      }
      if (!differences.empty()) squares.add(0.5 * std::pow(base::median(differences), 2));
    }
  }
  const double told = std::sqrt(squares.value + block_variance_);
  return squares.count < kEnough ? std::max(told, kVisitsToBlocks * std::sqrt(block_variance_)) : told;
}

}  // namespace soak::calib::gap
