// SPDX-License-Identifier: Apache-2.0
#include "calib/six_position.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/six_position/joint_fit.h"
#include "calib/six_position/missing.h"

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
      row.value -= off_c * row.scale_input * local_slope(problem, first_pass, row.visit, kScale);
    }
  }
}

/// A combination of the shared unknowns with its standard error; nothing where the segments do not show it.
std::optional<Estimate> combination(const Solution& solution, const Eigen::VectorXd& weights, double inflation) {
  if (!six_position::shows(solution, weights)) return std::nullopt;
  const double variance = weights.dot(solution.shared_covariance * weights);
  return Estimate{weights.dot(solution.shared), std::sqrt(std::max(0.0, variance)) * inflation};
}

Eigen::VectorXd unit_weight(const Solution& solution, Eigen::Index i) {
  return Eigen::VectorXd::Unit(solution.shared.size(), i);
}

/// Half the difference of a gyro's constants for axis j up and down; empty where one of the positions is missing.
Eigen::VectorXd up_minus_down(const Problem& problem, const Solution& solution, std::size_t j) {
  std::optional<Eigen::Index> up;
  std::optional<Eigen::Index> down;
  for (const Row& row : problem.rows) {
    const auto found = std::find(problem.nuisance.begin(), problem.nuisance.end(), row.label);
    if (found == problem.nuisance.end()) continue;
    const Eigen::Index column = 1 + (found - problem.nuisance.begin());
    if (row.up[j] > kOnAxis) up = column;
    if (row.up[j] < -kOnAxis) down = column;
  }
  if (!up || !down) return {};
  return 0.5 * (unit_weight(solution, *up) - unit_weight(solution, *down));
}

/// Weights of the shared unknowns that make the response to specific force along j, in units of g; empty: not shown.
Eigen::VectorXd coupling_weights(const Problem& problem, const Solution& solution, std::size_t j) {
  const std::size_t axis = axis_of(problem.sensor);
  if (is_gyro(problem.sensor)) {
    return j == axis ? unit_weight(solution, 0) : up_minus_down(problem, solution, j);
  }
  return unit_weight(solution, j == (axis + 1) % 3 ? 0 : 1);
}

void read_shared(const Problem& problem, const Solution& solution, double inflation, SensorEstimate& estimate) {
  if (solution.shared.size() == 0) return;
  const bool accel = !is_gyro(problem.sensor);
  const double g = problem.gravity_mps2;
  for (std::size_t j = 0; j < 3; ++j) {
    if (accel && j == axis_of(problem.sensor)) {
      estimate.coupling[j] = 0.0;
      continue;
    }
    const Eigen::VectorXd weights = coupling_weights(problem, solution, j);
    if (weights.size() == 0) continue;
    const auto value = combination(solution, weights, inflation);
    if (!value) continue;
    estimate.coupling[j] = value->value / g;
    estimate.coupling_se[j] = value->standard_error / std::abs(g);
  }
  if (!problem.with_even) return;
  const auto even = combination(solution, unit_weight(solution, six_position::kEven), inflation);
  if (even) estimate.even_order = Estimate{even->value / (g * g), even->standard_error / (g * g)};
}

/// What standard errors are multiplied by: residuals larger than the segments' own errors promise inflate them; where
/// those are not known, the residuals alone are the measure.
double inflation_of(const Problem& problem, const Solution& solution) {
  const double least = problem.typical_se > 0.0 ? 1.0 : 0.0;
  return std::sqrt(std::max(least, solution.reduced_chi_squared));
}

SensorEstimate read_solution(const Problem& problem, const Solution& solution) {
  SensorEstimate estimate;
  estimate.reduced_chi_squared = solution.reduced_chi_squared;
  const double inflation = inflation_of(problem, solution);
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
    if (solution.scale_known[v]) {
      // The column was f/g or rate over reference rate, so the unknown is S times that unit.
      const double ppm = 1e6 / six_position::scale_unit(problem);
      plateau.scale_ppm = ppm * solution.local[v][kScale];
      plateau.scale_se_ppm = std::abs(ppm) * std::sqrt(solution.local_variance[v][kScale]) * inflation;
    }
    estimate.plateaus.push_back(plateau);
  }
  read_shared(problem, solution, inflation, estimate);
  return estimate;
}

/// Solves with the even-order term where the segments show it, else without: bias is then not lost with it.
Solution solve_observable(Problem& problem) {
  Solution solution = six_position::solve(problem);
  if (!problem.with_even || six_position::shows(solution, unit_weight(solution, six_position::kEven))) return solution;
  problem.with_even = false;
  return six_position::solve(problem);
}

void warn_of_rates(std::span<const Segment> segments, std::vector<Warning>& warnings) {
  const auto turning = std::count_if(segments.begin(), segments.end(), six_position::turns);
  if (turning == 0) return;
  warnings.push_back(
      {"rate_positions", fmt::format("accelerometers: {} segments in which the fixture turns were left out, as the "
                                     "centripetal acceleration of an unknown lever arm is in them",
                                     turning)});
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
    carry_to_mean_temperature(problem, solve_observable(problem));
    const Solution solution = six_position::solve(problem);
    SensorEstimate& estimate = result.sensor[index_of(sensor)];
    estimate = read_solution(problem, solution);
    six_position::warn_of_missing(problem, estimate, result.warnings);
  }
  warn_of_rates(segments, result.warnings);
  return result;
}

}  // namespace soak::calib
