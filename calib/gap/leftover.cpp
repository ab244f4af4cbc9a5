// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/leftover.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

constexpr double kDay_s = 86400.0;

/// Indicator columns of all groups but the first; a group number below 0 belongs to none.
Eigen::MatrixXd indicators(const std::vector<int>& group) {
  std::map<int, Eigen::Index> column;
  for (const int g : group) {
    if (g >= 0) column.try_emplace(g, 0);
  }
  Eigen::Index next = -1;
  for (auto& [g, index] : column) index = next++;
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(group.size()), std::max<Eigen::Index>(0, next));
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (group[i] < 0) continue;
    const Eigen::Index index = column.at(group[i]);
    if (index >= 0) columns(static_cast<Eigen::Index>(i), index) = 1.0;
  }
  return columns;
}

template <class Group>
Eigen::MatrixXd by(const Observations& observations, Group group) {
  std::vector<int> groups;
  for (const Observation& row : observations.rows) groups.push_back(group(row));
  return indicators(groups);
}

void add(std::vector<Axis>& axes, std::string name, const Eigen::MatrixXd& columns) {
  if (columns.cols() == 0) return;
  Axis axis{.name = std::move(name), .candidate = {}};
  set_all(axis.candidate, columns);
  axes.push_back(std::move(axis));
}

void add_times(const Circumstances& c, std::vector<Axis>& axes) {
  if (!c.courses.utc_s().empty()) {
    const Eigen::ArrayXd angle = as_vector(c.courses.utc_s()).array() * (2.0 * std::numbers::pi / kDay_s);
    Eigen::MatrixXd day(angle.size(), 2);
    day.col(0) = angle.sin();
    day.col(1) = angle.cos();
    add(axes, "time of day", day);
  }
  if (!c.courses.since_power_s().empty()) {
    std::vector<int> octave;
    for (const double t_s : c.courses.since_power_s()) {
      octave.push_back(static_cast<int>(std::floor(std::log2(std::max(60.0, t_s)))));
    }
    add(axes, "time since power-on", indicators(octave));
  }
}

}  // namespace

std::vector<Axis> leftover_axes(const Circumstances& c) {
  const Observations& o = c.observations;
  std::vector<Axis> axes;
  if (!c.courses.blurred())
    add(axes, "temperature and direction of the sweep",
        by(o, [](const Observation& row) { return 2 * row.level + (row.sweep == Sweep::down ? 1 : 0); }));
  add(axes, "time since the fixture turned",
      by(o, [](const Observation& row) { return static_cast<int>(row.t_in_placement_s / 60.0); }));
  add(axes, "order of the positions in a visit", by(o, [](const Observation& row) { return row.order; }));
  if (o.has_positions()) {
    add(axes, "position", by(o, [](const Observation& row) { return row.position; }));
    add(axes, "position before", by(o, [](const Observation& row) { return row.previous; }));
    const Eigen::MatrixXd position = by(o, [](const Observation& row) { return row.position; });
    add(axes, "position and temperature", reduced_temperature(o).asDiagonal() * position);
  }
  add_times(c, axes);
  if (!c.courses.chamber_c().empty()) {
    Eigen::VectorXd across = as_vector(c.courses.chamber_c());
    for (Eigen::Index i = 0; i < across.size(); ++i) across(i) -= o.rows[static_cast<std::size_t>(i)].temp_c;
    add(axes, "chamber air less unit", across);
  }
  return axes;
}

}  // namespace soak::calib::gap
