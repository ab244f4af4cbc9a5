// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/six_position.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "base/linear/dense_solve.h"
#include "base/units.h"
#include "calib/estimate/detail/joint_fit.h"

namespace soak::calib {
namespace {

using six_position::kBias;
using six_position::kOnAxis;
using six_position::kScale;
using six_position::LevelFit;
using six_position::Local;
using six_position::Problem;
using six_position::Row;
using six_position::Solution;
using six_position::VisitInfo;

constexpr int kLevelPasses = 3;
constexpr double kLargestTilt_rad = 2.0 * base::kRadPerDeg;  ///< from 2.5° on no axis would count as vertical (kOnAxis)

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

/// Degrees of freedom of the standard errors where the residuals of a single visit inflate them; 0 = many.
double error_freedoms(const Problem& problem, const Solution& solution, double inflation) {
  if (inflation <= 1.0 || problem.visits.size() > 1) return 0.0;
  double unknowns = static_cast<double>(solution.shared.size());
  for (const VisitInfo& visit : problem.visits) unknowns += visit.with_scale ? 3.0 : 2.0;
  return std::max(1.0, static_cast<double>(problem.rows.size()) - unknowns);
}

SensorEstimate read_solution(const Problem& problem, const Solution& solution) {
  SensorEstimate estimate;
  estimate.reduced_chi_squared = solution.reduced_chi_squared;
  const double inflation = inflation_of(problem, solution);
  const double residual = error_freedoms(problem, solution, inflation);
  const auto fewer = [&](double of_wander) {
    if (solution.wander == 0.0) return residual;
    return residual > 0.0 ? std::min(residual, of_wander) : of_wander;
  };
  estimate.coupling_freedoms = fewer(solution.wander_freedoms.shared);
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
    plateau.bias_freedoms = fewer(solution.wander_freedoms.bias);
    plateau.scale_freedoms = fewer(solution.wander_freedoms.scale);
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

/// The fit of a sensor under a tilt of the vertical, its rows carried to the temperatures of their visits.
Problem carried(const Problem& rows, const Tilt& tilt) {
  Problem problem = six_position::pose(rows, tilt);
  if (!problem.rows.empty()) carry_to_mean_temperature(problem, solve_observable(problem));
  return problem;
}

/// The rows of the six sensors.
using SensorRows = std::array<Problem, kSensorCount>;

/// Estimates the level error and leaves it in `tilt` and `result`. The fit is linear in the tilts: the later passes
/// find what the accelerometers' scale errors make of the first.
std::optional<LevelFit> find_level(const SensorRows& rows, const Place& place, Tilt& tilt,
                                   SixPositionEstimate& result) {
  result.with_headings = place.headings.complete;
  result.no_level_error = place.headings.missing;
  if (!place.headings.complete) {
    if (place.headings.begun) {
      result.warnings.push_back(
          {"heading_incomplete", fmt::format("the azimuths of positions were not used: {}", place.headings.missing)});
    }
    return std::nullopt;
  }
  Tilt sum;
  LevelFit last;
  for (int pass = 0; pass < kLevelPasses; ++pass) {
    std::vector<Problem> accelerometers;
    for (const Sensor sensor : {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z}) {
      accelerometers.push_back(carried(rows[index_of(sensor)], sum));
    }
    auto answer = six_position::fit_level(accelerometers);
    result.no_level_error = answer.reason;
    if (!answer.fit) return std::nullopt;
    last = *answer.fit;
    sum.north_rad += last.tilt[0];
    sum.east_rad += last.tilt[1];
    const double size_rad = std::hypot(sum.north_rad, sum.east_rad);
    if (size_rad < kLargestTilt_rad) continue;
    result.no_level_error = fmt::format("the readings imply a level error of {:.3g}°, more than 2°: check the azimuths",
                                        size_rad * base::kDegPerRad);
    return std::nullopt;
  }
  tilt = sum;
  result.level_error = LevelError{{sum.north_rad, std::sqrt(last.covariance(0, 0))},
                                  {sum.east_rad, std::sqrt(last.covariance(1, 1))},
                                  {last.per_face_tilt[0], last.per_face_tilt[1]}};
  return last;
}

void add_change(double& standard_error, double changed, double value) {
  standard_error = std::hypot(standard_error, changed - value);
}

/// Adds to standard errors what one standard error of the tilt changes, along both axes of its error ellipse.
void widen(SensorEstimate& estimate, const SensorEstimate& other) {
  for (std::size_t p = 0; p < std::min(estimate.plateaus.size(), other.plateaus.size()); ++p) {
    PlateauEstimate& plateau = estimate.plateaus[p];
    add_change(plateau.bias_se, other.plateaus[p].bias, plateau.bias);
    if (!plateau.scale_ppm || !other.plateaus[p].scale_ppm) continue;
    add_change(*plateau.scale_se_ppm, *other.plateaus[p].scale_ppm, *plateau.scale_ppm);
  }
  for (std::size_t j = 0; j < 3; ++j) {
    if (!estimate.coupling[j] || !other.coupling[j]) continue;
    add_change(estimate.coupling_se[j], *other.coupling[j], *estimate.coupling[j]);
  }
  if (!estimate.even_order || !other.even_order) return;
  add_change(estimate.even_order->standard_error, other.even_order->value, estimate.even_order->value);
}

void widen_by_level(const Problem& rows, const Tilt& tilt, const Eigen::Matrix2d& covariance,
                    SensorEstimate& estimate) {
  const Eigen::Matrix2d root = base::cholesky(covariance);
  for (int k = 0; k < 2; ++k) {
    const Problem problem = carried(rows, {tilt.north_rad + root(0, k), tilt.east_rad + root(1, k)});
    widen(estimate, read_solution(problem, six_position::solve(problem)));
  }
}

// What the positions of a run do not show.

constexpr std::array<char, 3> kAxisLetters = {'x', 'y', 'z'};
constexpr double kHorizontal = 0.045;  ///< |up_i| under which axis i counts as horizontal: that of kOnAxis across

bool points_along(const Problem& problem, std::size_t axis, double sign) {
  return std::any_of(problem.rows.begin(), problem.rows.end(),
                     [&](const Row& row) { return sign * row.up[axis] > kOnAxis; });
}

/// Those of the six positions in which the sensor has no segment.
std::vector<std::string_view> missing_labels(const Problem& problem) {
  std::vector<std::string_view> missing;
  for (std::size_t i = 0; i < kSixPositionLabels.size(); ++i) {
    if (!points_along(problem, i / 2, i % 2 == 0 ? 1.0 : -1.0)) missing.push_back(kSixPositionLabels[i]);
  }
  return missing;
}

/// Whether gravity acts along the sensor's axis in a visit that does not show its scale error.
bool scale_in_bias(const Problem& problem) {
  const std::size_t axis = axis_of(problem.sensor);
  return std::any_of(problem.rows.begin(), problem.rows.end(), [&](const Row& row) {
    return !problem.visits[row.visit].with_scale && std::abs(row.up[axis]) > kHorizontal;
  });
}

/// Where an even-order term stays that counted as 0. With the axis up and down, two opposite horizontal positions would
/// show it, so a misalignment that is known comes from one of them alone.
std::string_view even_order_words(const Problem& problem, const SensorEstimate& estimate, bool any_scale) {
  const std::size_t axis = axis_of(problem.sensor);
  if (!any_scale) return "its even-order term";
  if (!points_along(problem, axis, 1.0) || !points_along(problem, axis, -1.0)) {
    return "its even-order term (which stays in the scale error; its bias is that at 0 g)";
  }
  const bool misaligned = estimate.coupling[(axis + 1) % 3] || estimate.coupling[(axis + 2) % 3];
  return misaligned ? "its even-order term (which stays in the misalignment)" : "its even-order term";
}

/// Whole °C of the visits that do not show the scale error.
std::set<int> temps_without_scale_c(const SensorEstimate& estimate) {
  std::set<int> temps_c;
  for (const PlateauEstimate& plateau : estimate.plateaus) {
    if (!plateau.scale_ppm) temps_c.insert(static_cast<int>(std::lround(plateau.temp_c)));
  }
  return temps_c;
}

std::vector<std::string> accelerometer_lacks(const Problem& problem, const SensorEstimate& estimate) {
  std::vector<std::string> lacks;
  const auto with_scale = std::count_if(estimate.plateaus.begin(), estimate.plateaus.end(),
                                        [](const PlateauEstimate& plateau) { return plateau.scale_ppm.has_value(); });
  const auto visits = static_cast<std::ptrdiff_t>(estimate.plateaus.size());
  if (with_scale < visits) {
    lacks.push_back(fmt::format("its scale error{}{}",
                                with_scale == 0
                                    ? ""
                                    : fmt::format(" at {} of {} plateau visits ({} °C)", visits - with_scale, visits,
                                                  fmt::join(temps_without_scale_c(estimate), ", ")),
                                scale_in_bias(problem) ? " (which stays in the bias)" : ""));
  }
  if (!estimate.even_order) lacks.emplace_back(even_order_words(problem, estimate, with_scale > 0));
  for (std::size_t j = 0; j < 3; ++j) {
    if (!estimate.coupling[j]) lacks.push_back(fmt::format("its misalignment along {}", kAxisLetters[j]));
  }
  return lacks;
}

std::vector<std::string> gyro_lacks(const Problem& problem, const SensorEstimate& estimate) {
  std::vector<std::string> lacks;
  const std::size_t axis = axis_of(problem.sensor);
  if (!points_along(problem, axis, 1.0) || !points_along(problem, axis, -1.0)) {
    lacks.emplace_back("its g-sensitivity (which stays in the bias, with the Earth's rotation)");
  } else {
    for (std::size_t j = 0; j < 3; ++j) {
      if (!estimate.coupling[j]) lacks.push_back(fmt::format("its g-sensitivity along {}", kAxisLetters[j]));
    }
  }
  const bool any_scale = std::any_of(estimate.plateaus.begin(), estimate.plateaus.end(),
                                     [](const PlateauEstimate& plateau) { return plateau.scale_ppm.has_value(); });
  if (problem.reference_rate_rps > 0.0 && !any_scale) {
    lacks.emplace_back("its scale error (no plateau visit has two rates about its axis in one position)");
  }
  return lacks;
}

/// Says what the positions do not show of a sensor, where it stays, and which of the six positions are missing. Silent
/// where nothing is missing, and of runs without positions.
void warn_of_missing(const Problem& problem, const SensorEstimate& estimate, std::vector<Warning>& warnings) {
  if (!problem.with_position) return;
  const auto lacks = is_gyro(problem.sensor) ? gyro_lacks(problem, estimate) : accelerometer_lacks(problem, estimate);
  const auto missing = missing_labels(problem);
  if (!lacks.empty()) {
    const std::string which = missing.empty() ? "" : fmt::format(" (missing: {})", fmt::join(missing, ", "));
    warnings.push_back({"missing_position", fmt::format("{}: the positions do not determine {}{}",
                                                        name_of(problem.sensor), fmt::join(lacks, "; "), which)});
  }
  const std::size_t lost = problem.visits.size() - estimate.plateaus.size();
  if (lost > 0) {
    warnings.push_back(
        {"missing_position", fmt::format("{}: {} plateau visits were left out: their positions do not show the bias",
                                         name_of(problem.sensor), lost)});
  }
}

}  // namespace

SixPositionEstimate estimate_six_positions(std::span<const Segment> segments, const Place& place,
                                           const UnitType& type) {
  SixPositionEstimate result;
  result.gravity = place.gravity;
  const auto turning = std::ranges::count_if(segments, turns);
  SensorRows rows;
  for (const Sensor sensor : kSensors) rows[index_of(sensor)] = six_position::rows_of(segments, sensor, place, type);
  Tilt tilt;
  const auto level = find_level(rows, place, tilt, result);
  for (const Sensor sensor : kSensors) {
    const Problem problem = carried(rows[index_of(sensor)], tilt);
    if (problem.rows.empty()) continue;
    SensorEstimate& estimate = result.sensor[index_of(sensor)];
    estimate = read_solution(problem, six_position::solve(problem));
    if (level && !is_gyro(sensor)) widen_by_level(rows[index_of(sensor)], tilt, level->covariance, estimate);
    warn_of_missing(problem, estimate, result.warnings);
  }
  if (turning > 0) {
    result.warnings.push_back(
        {"rate_positions", fmt::format("accelerometers: {} segments in which the fixture turns were left out because "
                                       "they contain the centripetal acceleration of an unknown lever arm",
                                       turning)});
  }
  return result;
}

}  // namespace soak::calib
