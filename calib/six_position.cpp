// SPDX-License-Identifier: Apache-2.0
#include "calib/six_position.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "calib/statistics.h"

namespace soak::calib {
namespace {

constexpr double kOnAxis = 0.999;          ///< |up_i| from which axis i counts as vertical
constexpr double kScaleSpan = 0.5;         ///< spread of up_i within a visit from which its scale is observable
constexpr double kPoolingStrength = 20.0;  ///< prior degrees of freedom of the run's typical standard error
constexpr int kDriftIterations = 15;

/// One segment as a row of the joint fit of one sensor.
struct Row {
  std::size_t visit;  ///< index into Problem::visits
  double value;
  double weight;
  double temp_c;
  double tau;  ///< time from the middle of the visit in units of the longest half visit of the run
  Vector3 up;
  std::string label;
};

struct VisitInfo {
  std::int32_t visit = 0;
  Sweep sweep = Sweep::unknown;
  std::optional<double> plateau_c;
  double temp_c = 0.0;
  double t_s = 0.0;
  std::size_t rows = 0;
  bool with_scale = false;
};

/// The joint fit of one sensor in one run.
struct Problem {
  Sensor sensor = Sensor::gyro_x;
  double gravity_mps2 = 0.0;
  std::vector<Row> rows;
  std::vector<VisitInfo> visits;
  std::vector<std::string> nuisance;  ///< labels with their own constant (gyros)
  bool with_position = false;
  double typical_se = 0.0;
};

/// Unknowns of one visit, in this order.
enum Local : int { kBias, kDrift, kScale, kLocalCount };

using LocalMatrix = Eigen::Matrix<double, kLocalCount, kLocalCount>;
using LocalVector = Eigen::Matrix<double, kLocalCount, 1>;

struct Solution {
  std::vector<LocalVector> local;
  std::vector<LocalVector> local_variance;  ///< diagonal of the covariance
  std::vector<bool> bias_known;
  Eigen::VectorXd shared;
  Eigen::VectorXd shared_variance;
  double reduced_chi_squared = 0.0;
};

bool usable(const Segment& segment, Sensor sensor) {
  return segment.plateau_c && segment.phase == Phase::soak && segment.sensor[index_of(sensor)].count > 0;
}

/// Standard error for weighting: that of 30 samples is itself uncertain, so it leans on the run's median.
double pooled_se(const SensorStatistics& statistics, double typical_se) {
  if (typical_se <= 0.0) return 1.0;
  const double white_variance = statistics.variance / static_cast<double>(std::max<std::size_t>(1, statistics.count));
  const double inflation = white_variance > 0.0
                               ? std::max(1.0, statistics.standard_error * statistics.standard_error / white_variance)
                               : 1.0;
  const double own_dof = std::max(0.0, static_cast<double>(statistics.count) / inflation - 1.0);
  const double own = statistics.standard_error * statistics.standard_error;
  return std::sqrt((kPoolingStrength * typical_se * typical_se + own_dof * own) / (kPoolingStrength + own_dof));
}

double typical_se(std::span<const Segment> segments, Sensor sensor) {
  std::vector<double> errors;
  for (const Segment& segment : segments) {
    if (usable(segment, sensor)) errors.push_back(segment.sensor[index_of(sensor)].standard_error);
  }
  const double middle = median(errors);
  if (middle > 0.0) return middle;
  const auto largest = std::max_element(errors.begin(), errors.end());
  return largest != errors.end() ? *largest : 0.0;
}

std::vector<VisitInfo> collect_visits(std::span<const Segment> segments, Sensor sensor,
                                      std::map<std::int32_t, std::size_t>& index) {
  std::vector<VisitInfo> visits;
  for (const Segment& segment : segments) {
    if (!usable(segment, sensor)) continue;
    const auto [entry, added] = index.try_emplace(segment.key.visit, visits.size());
    if (added) visits.push_back({segment.key.visit, segment.sweep, segment.plateau_c});
    VisitInfo& visit = visits[entry->second];
    visit.temp_c += segment.sensor_temp_c[index_of(sensor)];
    visit.t_s += 0.5 * (segment.t_start_s + segment.t_end_s);
    ++visit.rows;
  }
  for (VisitInfo& visit : visits) {
    visit.temp_c /= static_cast<double>(visit.rows);
    visit.t_s /= static_cast<double>(visit.rows);
  }
  return visits;
}

/// What is known of the reading beforehand: gravity on accelerometers, the vertical part of the Earth's rate on gyros.
double known_part(const Problem& problem, const Vector3& up, double vertical_rate_rps) {
  const double up_i = up[axis_of(problem.sensor)];
  return is_gyro(problem.sensor) ? vertical_rate_rps * up_i : problem.gravity_mps2 * up_i;
}

Problem pose(std::span<const Segment> segments, Sensor sensor, double gravity_mps2, double vertical_rate_rps,
             int sign) {
  Problem problem;
  problem.sensor = sensor;
  problem.gravity_mps2 = is_gyro(sensor) ? gravity_mps2 : gravity_mps2 * sign;
  problem.typical_se = typical_se(segments, sensor);
  problem.with_position =
      std::any_of(segments.begin(), segments.end(), [](const Segment& s) { return s.position.has_value(); });
  std::vector<Segment> kept;
  for (const Segment& segment : segments) {
    if (usable(segment, sensor) && segment.position.has_value() == problem.with_position) kept.push_back(segment);
  }
  std::map<std::int32_t, std::size_t> index;
  problem.visits = collect_visits(kept, sensor, index);

  double longest_half_s = 0.0;
  for (const Segment& segment : kept) {
    const double middle_s = 0.5 * (segment.t_start_s + segment.t_end_s);
    longest_half_s = std::max(longest_half_s, std::abs(middle_s - problem.visits[index[segment.key.visit]].t_s));
  }
  for (const Segment& segment : kept) {
    const std::size_t visit = index[segment.key.visit];
    const SensorStatistics& statistics = segment.sensor[index_of(sensor)];
    const double se = pooled_se(statistics, problem.typical_se);
    const double from_middle_s = 0.5 * (segment.t_start_s + segment.t_end_s) - problem.visits[visit].t_s;
    Row row{visit,
            statistics.mean,
            1.0 / (se * se),
            segment.sensor_temp_c[index_of(sensor)],
            longest_half_s > 0.0 ? from_middle_s / longest_half_s : 0.0,
            {},
            segment.key.position};
    if (segment.position) {
      row.up = segment.position->up;
      row.value -= known_part(problem, row.up, vertical_rate_rps);
    }
    problem.rows.push_back(std::move(row));
  }
  return problem;
}

/// Decides which unknowns the positions of the run can show.
void choose_unknowns(Problem& problem) {
  const std::size_t axis = axis_of(problem.sensor);
  if (!problem.with_position) return;
  if (is_gyro(problem.sensor)) {
    bool up = false;
    bool down = false;
    for (const Row& row : problem.rows) {
      up = up || row.up[axis] > kOnAxis;
      down = down || row.up[axis] < -kOnAxis;
    }
    if (!up || !down) return;
    for (const Row& row : problem.rows) {
      const bool vertical = std::abs(row.up[axis]) > kOnAxis;
      const bool listed =
          std::find(problem.nuisance.begin(), problem.nuisance.end(), row.label) != problem.nuisance.end();
      if (!vertical && !listed) problem.nuisance.push_back(row.label);
    }
    return;
  }
  for (std::size_t v = 0; v < problem.visits.size(); ++v) {
    double low = 1.0;
    double high = -1.0;
    for (const Row& row : problem.rows) {
      if (row.visit != v) continue;
      low = std::min(low, row.up[axis]);
      high = std::max(high, row.up[axis]);
    }
    problem.visits[v].with_scale = high - low >= kScaleSpan;
  }
}

/// Number of shared unknowns. Accelerometer: couplings to the two other axes. Gyro: to its own, then the nuisances.
Eigen::Index shared_count(const Problem& problem) {
  if (!problem.with_position) return 0;
  if (!is_gyro(problem.sensor)) return 2;
  return problem.nuisance.empty() ? 0 : 1 + static_cast<Eigen::Index>(problem.nuisance.size());
}

LocalVector local_row(const Problem& problem, const Row& row) {
  LocalVector a = LocalVector::Zero();
  a[kBias] = 1.0;
  a[kDrift] = row.tau;
  // Columns are in units of g, so that all unknowns have the size of a reading.
  if (problem.visits[row.visit].with_scale) a[kScale] = row.up[axis_of(problem.sensor)];
  return a;
}

Eigen::VectorXd shared_row(const Problem& problem, const Row& row) {
  Eigen::VectorXd a = Eigen::VectorXd::Zero(shared_count(problem));
  if (a.size() == 0) return a;
  const std::size_t axis = axis_of(problem.sensor);
  if (!is_gyro(problem.sensor)) {
    a[0] = row.up[(axis + 1) % 3];
    a[1] = row.up[(axis + 2) % 3];
    return a;
  }
  a[0] = std::abs(row.up[axis]) > kOnAxis ? row.up[axis] : 0.0;
  const auto found = std::find(problem.nuisance.begin(), problem.nuisance.end(), row.label);
  if (found != problem.nuisance.end()) a[1 + (found - problem.nuisance.begin())] = 1.0;
  return a;
}

/// Normal equations of one visit after whitening; the unknowns' sizes are alike, so their condition is small.
struct LocalNormal {
  LocalMatrix own = LocalMatrix::Zero();
  Eigen::MatrixXd cross;
  LocalVector right = LocalVector::Zero();
};

struct Normal {
  std::vector<LocalNormal> local;
  Eigen::MatrixXd shared;
  Eigen::VectorXd shared_right;
};

Normal assemble(const Problem& problem) {
  const Eigen::Index k = shared_count(problem);
  Normal normal{std::vector<LocalNormal>(problem.visits.size()), Eigen::MatrixXd::Zero(k, k), Eigen::VectorXd::Zero(k)};
  for (LocalNormal& local : normal.local) local.cross = Eigen::MatrixXd::Zero(kLocalCount, k);
  for (const Row& row : problem.rows) {
    LocalNormal& local = normal.local[row.visit];
    const LocalVector a = local_row(problem, row);
    const Eigen::VectorXd s = shared_row(problem, row);
    local.own += row.weight * a * a.transpose();
    local.cross += row.weight * a * s.transpose();
    local.right += row.weight * a * row.value;
    normal.shared += row.weight * s * s.transpose();
    normal.shared_right += row.weight * s * row.value;
  }
  return normal;
}

/// Pseudo-inverse of a symmetric matrix; `null` receives the directions without information.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix, Eigen::MatrixXd& null) {
  if (matrix.size() == 0) return matrix;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
  const double floor = 1e-9 * std::max(1e-300, eigen.eigenvalues().cwiseAbs().maxCoeff());
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(matrix.rows());
  std::vector<Eigen::Index> empty;
  for (Eigen::Index i = 0; i < inverse.size(); ++i) {
    if (eigen.eigenvalues()[i] > floor) {
      inverse[i] = 1.0 / eigen.eigenvalues()[i];
    } else {
      empty.push_back(i);
    }
  }
  null = eigen.eigenvectors()(Eigen::all, empty);
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

/// Weighted least squares with a drift of variance `drift_variance` per visit: each visit's own unknowns are eliminated
/// (Schur complement), the shared ones solved, the rest substituted back.
Solution solve(const Problem& problem, const Normal& normal, double drift_variance) {
  const std::size_t n = problem.visits.size();
  std::vector<LocalMatrix> inverse(n);
  Eigen::MatrixXd schur = normal.shared;
  Eigen::VectorXd right = normal.shared_right;
  for (std::size_t v = 0; v < n; ++v) {
    LocalMatrix own = normal.local[v].own;
    own(kDrift, kDrift) += 1.0 / drift_variance;
    if (!problem.visits[v].with_scale) own(kScale, kScale) = own(kBias, kBias);
    inverse[v] = own.inverse();
    schur -= normal.local[v].cross.transpose() * inverse[v] * normal.local[v].cross;
    right -= normal.local[v].cross.transpose() * inverse[v] * normal.local[v].right;
  }
  Solution solution;
  Eigen::MatrixXd null;
  const Eigen::MatrixXd shared_covariance = pseudo_inverse(schur, null);
  solution.shared = shared_covariance * right;
  solution.shared_variance = shared_covariance.diagonal();
  for (std::size_t v = 0; v < n; ++v) {
    const Eigen::MatrixXd carry = inverse[v] * normal.local[v].cross;
    solution.local.push_back(inverse[v] * normal.local[v].right - carry * solution.shared);
    solution.local_variance.push_back(
        (LocalMatrix(inverse[v]) + LocalMatrix(carry * shared_covariance * carry.transpose())).diagonal());
    solution.bias_known.push_back(null.size() == 0 || (carry.row(kBias) * null).cwiseAbs().maxCoeff() < 1e-6);
  }
  return solution;
}

void judge_residuals(const Problem& problem, Solution& solution, double drift_variance) {
  double chi_squared = 0.0;
  double unknowns = static_cast<double>(shared_count(problem));
  for (const Row& row : problem.rows) {
    const double fitted =
        local_row(problem, row).dot(solution.local[row.visit]) + shared_row(problem, row).dot(solution.shared);
    chi_squared += row.weight * (row.value - fitted) * (row.value - fitted);
  }
  for (std::size_t v = 0; v < problem.visits.size(); ++v) {
    const double drift = solution.local[v][kDrift];
    chi_squared += drift * drift / drift_variance;
    unknowns += problem.visits[v].with_scale ? 2.0 : 1.0;
  }
  const double degrees = static_cast<double>(problem.rows.size()) - unknowns;
  solution.reduced_chi_squared = degrees > 0.5 ? chi_squared / degrees : 0.0;
}

/// Solves with the drift's variance estimated by expectation-maximisation from a start at the typical standard error.
Solution solve_with_drift(const Problem& problem) {
  const Normal normal = assemble(problem);
  const double unit = problem.typical_se > 0.0 ? problem.typical_se * problem.typical_se : 1.0;
  double drift_variance = unit;
  Solution solution = solve(problem, normal, drift_variance);
  for (int i = 0; i < kDriftIterations; ++i) {
    double sum = 0.0;
    for (std::size_t v = 0; v < problem.visits.size(); ++v) {
      sum += solution.local[v][kDrift] * solution.local[v][kDrift] + solution.local_variance[v][kDrift];
    }
    drift_variance = std::max(1e-6 * unit, sum / static_cast<double>(problem.visits.size()));
    solution = solve(problem, normal, drift_variance);
  }
  judge_residuals(problem, solution, drift_variance);
  return solution;
}

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
  const double vertical_rate_rps = site.latitude_deg ? vertical_earth_rate_rps(*site.latitude_deg) : 0.0;
  for (const Sensor sensor : kSensors) {
    Problem problem = pose(segments, sensor, result.gravity.mps2, vertical_rate_rps, type.sign_at_rest);
    if (problem.rows.empty()) continue;
    choose_unknowns(problem);
    carry_to_mean_temperature(problem, solve_with_drift(problem));
    const Solution solution = solve_with_drift(problem);
    SensorEstimate& estimate = result.sensor[index_of(sensor)];
    estimate = read_solution(problem, solution);
    warn(problem, estimate, result.warnings);
  }
  return result;
}

}  // namespace soak::calib
