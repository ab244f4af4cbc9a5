// SPDX-License-Identifier: Apache-2.0
#include "calib/six_position.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "calib/six_position/joint_fit.h"

namespace soak::calib {
namespace {

using six_position::kBias;
using six_position::kOnAxis;
using six_position::kScale;
using six_position::Local;
using six_position::Problem;
using six_position::Row;
using six_position::Solution;
using six_position::VisitInfo;

/// Slope of unknown `which` against temperature at visit v, from its neighbours in the order of visits.
double local_slope(const Problem& problem, const Solution& solution, std::size_t v, Local which) {
  const std::size_t before = v > 0 ? v - 1 : v;
  const std::size_t after = v + 1 < problem.visits.size() ? v + 1 : v;
  const auto slope = [&](std::size_t a, std::size_t b) {
    const double dt = problem.visits[b].temp_c - problem.visits[a].temp_c;
    return std::abs(dt) < 1.0 ? 0.0 : (solution.local[b][which] - solution.local[a][which]) / dt;
  };
  // At a turning plateau both neighbours lie on one side and the chord between them means nothing.
  const double there = problem.visits[v].temp_c;
  const bool straddles =
      (problem.visits[before].temp_c - there) * (problem.visits[after].temp_c - there) < 0.0 && before != after;
  return straddles ? slope(before, after) : slope(before, before == v ? after : v);
}

void carry_to_mean_temperature(Problem& problem, const Solution& first_pass) {
  for (Row& row : problem.rows) {
    const double off_c = row.temp_c - problem.visits[row.visit].temp_c;
    row.value -= off_c * local_slope(problem, first_pass, row.visit, kBias);
    if (problem.visits[row.visit].with_scale) {
      row.value -= off_c * row.up[axis_of(problem.sensor)] * local_slope(problem, first_pass, row.visit, kScale);
    }
  }
}

void read_couplings(const Problem& problem, const Solution& solution, double inflation, SensorEstimate& estimate) {
  const std::size_t axis = axis_of(problem.sensor);
  const double g = problem.gravity_mps2;
  const auto set = [&](std::size_t j, double value, double variance) {
    if (variance <= 0.0) return;
    estimate.coupling[j] = value / g;
    estimate.coupling_se[j] = std::sqrt(variance) * inflation / std::abs(g);
  };
  if (solution.shared.size() == 0) return;
  if (!is_gyro(problem.sensor)) {
    estimate.coupling[axis] = 0.0;
    set((axis + 1) % 3, solution.shared[0], solution.shared_variance[0]);
    set((axis + 2) % 3, solution.shared[1], solution.shared_variance[1]);
    return;
  }
  set(axis, solution.shared[0], solution.shared_variance[0]);
  for (std::size_t j = 0; j < 3; ++j) {
    if (j == axis) continue;
    std::optional<std::size_t> up;
    std::optional<std::size_t> down;
    for (const Row& row : problem.rows) {
      const auto found = std::find(problem.nuisance.begin(), problem.nuisance.end(), row.label);
      if (found == problem.nuisance.end()) continue;
      const auto column = static_cast<std::size_t>(1 + (found - problem.nuisance.begin()));
      if (row.up[j] > kOnAxis) up = column;
      if (row.up[j] < -kOnAxis) down = column;
    }
    if (!up || !down) continue;
    const auto u = static_cast<Eigen::Index>(*up);
    const auto d = static_cast<Eigen::Index>(*down);
    set(j, 0.5 * (solution.shared[u] - solution.shared[d]),
        0.25 * (solution.shared_variance[u] + solution.shared_variance[d]));
  }
}

SensorEstimate read_solution(const Problem& problem, const Solution& solution) {
  SensorEstimate estimate;
  estimate.reduced_chi_squared = solution.reduced_chi_squared;
  const double inflation = std::sqrt(std::max(1.0, solution.reduced_chi_squared));
  for (std::size_t v = 0; v < problem.visits.size(); ++v) {
    if (!solution.bias_known[v]) continue;
    const VisitInfo& visit = problem.visits[v];
    PlateauEstimate plateau;
    plateau.visit = visit.visit;
    plateau.sweep = visit.sweep;
    plateau.plateau_c = visit.plateau_c;
    plateau.temp_c = visit.temp_c;
    plateau.t_s = visit.t_s;
    plateau.bias = solution.local[v][kBias];
    plateau.bias_se = std::sqrt(solution.local_variance[v][kBias]) * inflation;
    if (visit.with_scale) {
      // The column was up_i, so the unknown is S·g.
      plateau.scale_ppm = 1e6 * solution.local[v][kScale] / problem.gravity_mps2;
      plateau.scale_se_ppm =
          1e6 * std::sqrt(solution.local_variance[v][kScale]) * inflation / std::abs(problem.gravity_mps2);
    }
    estimate.plateaus.push_back(plateau);
  }
  read_couplings(problem, solution, inflation, estimate);
  return estimate;
}

void warn(const Problem& problem, const SensorEstimate& estimate, std::vector<Warning>& warnings) {
  const std::string_view name = name_of(problem.sensor);
  if (problem.with_position && is_gyro(problem.sensor) && problem.nuisance.empty()) {
    warnings.push_back(
        {"missing_position",
         fmt::format("{}: its axis was never both up and down, so g-sensitivity and the Earth's rotation "
                     "stay in its bias",
                     name)});
  }
  if (problem.with_position && !is_gyro(problem.sensor) &&
      std::any_of(problem.visits.begin(), problem.visits.end(), [](const VisitInfo& v) { return !v.with_scale; })) {
    warnings.push_back(
        {"missing_position",
         fmt::format("{}: at some plateaus its axis was not turned, so bias holds the scale error there", name)});
  }
  const std::size_t lost = problem.visits.size() - estimate.plateaus.size();
  if (lost > 0) {
    warnings.push_back(
        {"missing_position",
         fmt::format("{}: {} plateau visits were left out: their positions do not show the bias", name, lost)});
  }
}

}  // namespace

SixPositionEstimate estimate_six_positions(std::span<const Segment> segments, const Site& site, const UnitType& type) {
  SixPositionEstimate result;
  result.gravity = gravity_at(site);
  const six_position::Circumstances circumstances{
      result.gravity.mps2, site.latitude_deg ? vertical_earth_rate_rps(*site.latitude_deg) : 0.0, type.sign_at_rest};
  for (const Sensor sensor : kSensors) {
    Problem problem = six_position::pose(segments, sensor, circumstances);
    if (problem.rows.empty()) continue;
    carry_to_mean_temperature(problem, six_position::solve(problem));
    const Solution solution = six_position::solve(problem);
    SensorEstimate& estimate = result.sensor[index_of(sensor)];
    estimate = read_solution(problem, solution);
    warn(problem, estimate, result.warnings);
  }
  return result;
}

}  // namespace soak::calib
