// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/joint_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"
#include "base/units.h"
#include "calib/estimate/detail/session_wander.h"

namespace soak::calib::six_position {
namespace {

// From segments to the posed fit.

constexpr double kScaleSpan = 0.5;         ///< spread of scale_input within a visit that makes its scale observable
constexpr double kPoolingStrength = 20.0;  ///< prior degrees of freedom of the run's typical standard error

/// Accelerometers of a turning unit read the centripetal acceleration of an unknown lever arm too; gyros across the
/// axis of rotation their misalignment, which is not among the unknowns.
bool usable(const Segment& segment, Sensor sensor) {
  const bool recorded = segment.plateau_c && segment.phase == Phase::soak && segment.sensor[index_of(sensor)].count > 0;
  if (!recorded || !turns(segment)) return recorded;
  return is_gyro(sensor) && std::abs(segment.position->up[axis_of(sensor)]) > kOnAxis;
}

/// Fixture's rate along the sensor's axis.
double rate_rps(const Segment& segment, Sensor sensor) {
  if (!turns(segment)) return 0.0;
  return *segment.position->rate_dps * base::kRadPerDeg * segment.position->up[axis_of(sensor)];
}

double largest_rate_rps(std::span<const Segment* const> segments, Sensor sensor) {
  double largest = 0.0;
  for (const Segment* segment : segments) largest = std::max(largest, std::abs(rate_rps(*segment, sensor)));
  return largest;
}

/// Range of values, empty at first.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double span() const { return high > low ? high - low : 0.0; }
};

/// Leaves out turning segments of visits in which no other rate tells scale error from bias.
void drop_lone_rates(std::vector<const Segment*>& segments, Sensor sensor, double reference_rate_rps) {
  std::map<std::int32_t, Range> rates;
  for (const Segment* segment : segments) rates[segment->key.visit].add(rate_rps(*segment, sensor));
  std::erase_if(segments, [&](const Segment* segment) {
    return turns(*segment) && rates[segment->key.visit].span() < kScaleSpan * reference_rate_rps;
  });
}

/// Standard error for weighting: that of 30 samples is itself uncertain, so it leans on the run's median. Where the run
/// states none at all, all segments weigh the same, in a unit that says nothing of their size (Problem::typical_se).
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
  const double middle = base::median(errors);
  if (middle > 0.0) return middle;
  const auto largest = std::max_element(errors.begin(), errors.end());
  return largest != errors.end() ? *largest : 0.0;
}

std::vector<VisitInfo> collect_visits(std::span<const Segment* const> segments, Sensor sensor,
                                      std::map<std::int32_t, std::size_t>& index) {
  std::vector<VisitInfo> visits;
  for (const Segment* segment : segments) {
    const auto [entry, added] = index.try_emplace(segment->key.visit, visits.size());
    if (added) visits.push_back({segment->key.visit, segment->sweep, segment->plateau_c});
    VisitInfo& visit = visits[entry->second];
    visit.temp_c += segment->sensor_temp_c[index_of(sensor)];
    visit.t_s += 0.5 * (segment->t_start_s + segment->t_end_s);
    ++visit.rows;
  }
  for (VisitInfo& visit : visits) {
    visit.temp_c /= static_cast<double>(visit.rows);
    visit.t_s /= static_cast<double>(visit.rows);
  }
  return visits;
}

/// Where the axes of the unit point: as the position says, tilted and with north and east where the headings are known.
/// A unit that turns sees the tilts of whole turns cancel.
void orient(Row& row, const std::optional<double>& azimuth_deg, const Tilt& tilt) {
  row.up = row.position->up;
  if (!azimuth_deg || row.turning) return;
  const Frame frame = frame_of(*row.position, *azimuth_deg, tilt);
  row.up = frame.up;
  row.north = frame.north;
  row.east = frame.east;
}

/// What is known of the reading beforehand: gravity on accelerometers, the Earth's rate and the fixture's on gyros.
double known_part(const Problem& problem, const Row& row) {
  const std::size_t axis = axis_of(problem.sensor);
  if (!is_gyro(problem.sensor)) return problem.gravity_mps2 * row.up[axis];
  return problem.earth.vertical_rps * row.up[axis] + problem.earth.horizontal_rps * row.north[axis] + row.rate_rps;
}

/// Constants for the positions in which a gyro's axis is not vertical, where its own up/down pair gives the level.
void choose_nuisances(Problem& problem) {
  const std::size_t axis = axis_of(problem.sensor);
  bool up = false;
  bool down = false;
  for (const Row& row : problem.rows) {
    up = up || row.up[axis] > kOnAxis;
    down = down || row.up[axis] < -kOnAxis;
  }
  problem.with_coupling = up && down;
  if (!problem.with_coupling) return;
  for (const Row& row : problem.rows) {
    const bool vertical = std::abs(row.up[axis]) > kOnAxis;
    const bool listed =
        std::find(problem.nuisance.begin(), problem.nuisance.end(), row.label) != problem.nuisance.end();
    if (!vertical && !listed) problem.nuisance.push_back(row.label);
  }
}

/// Whether the positions turn axis `a` both up and down.
bool both_ways(const Problem& problem, std::size_t a) {
  const auto there = [&](double sign) {
    return std::ranges::any_of(problem.rows, [&](const Row& row) { return sign * row.up[a] > kOnAxis; });
  };
  return there(1.0) && there(-1.0);
}

void choose_scales(Problem& problem) {
  std::vector<Range> inputs(problem.visits.size());
  for (const Row& row : problem.rows) inputs[row.visit].add(row.scale_input);
  for (std::size_t v = 0; v < inputs.size(); ++v) problem.visits[v].with_scale = inputs[v].span() >= kScaleSpan;
}

Row row_of(const Segment& segment, const Problem& problem, std::size_t visit) {
  const SensorStatistics& statistics = segment.sensor[index_of(problem.sensor)];
  const double se = pooled_se(statistics, problem.typical_se);
  Row row;
  row.visit = visit;
  row.mean = statistics.mean;
  row.weight = 1.0 / (se * se);
  row.temp_c = segment.sensor_temp_c[index_of(problem.sensor)];
  row.tau = 0.5 * (segment.t_start_s + segment.t_end_s) - problem.visits[visit].t_s;
  row.rate_rps = rate_rps(segment, problem.sensor);
  row.turning = turns(segment);
  row.label = segment.key.position;
  row.position = segment.position;
  return row;
}

/// Times from the middles of the visits in units of the longest.
void normalise_times(Problem& problem) {
  double longest = 0.0;
  for (const Row& row : problem.rows) longest = std::max(longest, std::abs(row.tau));
  if (longest == 0.0) return;
  for (Row& row : problem.rows) row.tau /= longest;
}

// Solving it.

constexpr int kDriftIterations = 15;
constexpr double kWanderStep = 0.01;             ///< of its variance, for a derivative
constexpr std::size_t kMostRowsForWander = 400;  ///< more rows on a bench are none that somebody turned by hand

using LocalMatrix = Eigen::Matrix<double, kLocalCount, kLocalCount>;

constexpr double kOpen = 1e-6;  ///< share of an open direction from which an unknown counts as open

Eigen::Index contrast_index(const Problem& problem) { return problem.with_even ? 3 : 2; }

/// Number of shared unknowns. Accelerometer: couplings to the two other axes, then the even-order term, then the
/// contrast of the horizontal faces, then the tilts of the vertical to north and east. Gyro: to its own, then the
/// nuisances.
Eigen::Index shared_count(const Problem& problem) {
  if (!problem.with_position) return 0;
  if (!is_gyro(problem.sensor)) {
    return contrast_index(problem) + (problem.with_contrast ? 1 : 0) + (problem.with_level ? kLevelCount : 0);
  }
  return problem.with_coupling ? 1 + static_cast<Eigen::Index>(problem.nuisance.size()) : 0;
}

LocalVector local_row(const Problem& problem, const Row& row) {
  LocalVector a = LocalVector::Zero();
  a[kBias] = 1.0;
  a[kDrift] = row.tau;
  // Columns are in units of g, so that all unknowns have the size of a reading.
  if (problem.visits[row.visit].with_scale) a[kScale] = row.scale_input;
  return a;
}

Eigen::VectorXd shared_row(const Problem& problem, const Row& row) {
  Eigen::VectorXd a = Eigen::VectorXd::Zero(shared_count(problem));
  if (a.size() == 0) return a;
  const std::size_t axis = axis_of(problem.sensor);
  if (!is_gyro(problem.sensor)) {
    a[0] = row.up[(axis + 1) % 3];
    a[1] = row.up[(axis + 2) % 3];
    // K₂(f² − g²): 0 where the axis is vertical, so that b stays (up + down)/2 and no tilt of the horizontal faces
    // reaches it.
    if (problem.with_even) a[kEven] = row.up[axis] * row.up[axis] - 1.0;
    // What is left of four faces that are not square once M and K₂ have had theirs: it would pass for a drift, the same
    // in every visit, which reaches the level of b.
    if (problem.with_contrast) a[contrast_index(problem)] = a[0] * a[0] - a[1] * a[1];
    if (problem.with_level) a.tail<kLevelCount>() << row.north[axis], row.east[axis];
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

/// The rows of the fit as they are: the visit's own columns, the shared ones, the value.
struct Equations {
  Eigen::MatrixXd local;
  Eigen::MatrixXd shared;
  Eigen::VectorXd value;
};

Equations equations_of(const Problem& problem) {
  const auto n = static_cast<Eigen::Index>(problem.rows.size());
  Equations equations{Eigen::MatrixXd(n, Eigen::Index{kLocalCount}), Eigen::MatrixXd(n, shared_count(problem)),
                      Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Row& row = problem.rows[static_cast<std::size_t>(i)];
    equations.local.row(i) = local_row(problem, row).transpose();
    equations.shared.row(i) = shared_row(problem, row).transpose();
    equations.value[i] = row.value;
  }
  return equations;
}

Eigen::VectorXd column_of(const Problem& problem, double Row::* member) {
  Eigen::VectorXd column(static_cast<Eigen::Index>(problem.rows.size()));
  for (Eigen::Index i = 0; i < column.size(); ++i) column[i] = problem.rows[static_cast<std::size_t>(i)].*member;
  return column;
}

/// The rows with noise of variance 1, one independent of the other. `wander`: variance of a random walk over the one
/// visit that there is, 0 = none.
Equations whitened(const Problem& problem, double wander) {
  Equations rows = equations_of(problem);
  const Eigen::VectorXd weight = column_of(problem, &Row::weight);
  if (wander == 0.0) {
    const Eigen::VectorXd root = weight.cwiseSqrt();
    return {root.asDiagonal() * rows.local, root.asDiagonal() * rows.shared, root.cwiseProduct(rows.value)};
  }
  Eigen::MatrixXd covariance = wander * walk_about_its_mean(column_of(problem, &Row::tau));
  covariance.diagonal() += weight.cwiseInverse();
  const Eigen::MatrixXd lower = base::cholesky(covariance);
  return {base::solve_lower(lower, rows.local), base::solve_lower(lower, rows.shared),
          base::solve_lower(lower, rows.value)};
}

Normal assemble(const Problem& problem, double wander) {
  const Eigen::Index k = shared_count(problem);
  Normal normal{std::vector<LocalNormal>(problem.visits.size()), Eigen::MatrixXd::Zero(k, k), Eigen::VectorXd::Zero(k)};
  for (LocalNormal& local : normal.local) local.cross = Eigen::MatrixXd::Zero(kLocalCount, k);
  const Equations rows = whitened(problem, wander);
  for (Eigen::Index i = 0; i < rows.value.size(); ++i) {
    LocalNormal& local = normal.local[problem.rows[static_cast<std::size_t>(i)].visit];
    const LocalVector a = rows.local.row(i).transpose();
    const Eigen::VectorXd s = rows.shared.row(i).transpose();
    local.own += a * a.transpose();
    local.cross += a * s.transpose();
    local.right += a * rows.value[i];
    normal.shared += s * s.transpose();
    normal.shared_right += s * rows.value[i];
  }
  return normal;
}

/// Of a gyro in a session of one visit; nothing where the noise of the rows is not known.
SessionWander wander_of(const Problem& problem) {
  const std::size_t n = problem.rows.size();
  if (!is_gyro(problem.sensor) || problem.visits.size() != 1 || problem.typical_se <= 0.0 || n > kMostRowsForWander)
    return {};
  const Equations rows = equations_of(problem);
  Eigen::MatrixXd design(rows.value.size(), rows.local.cols() + rows.shared.cols());
  design << rows.local, rows.shared;
  return estimate_session_wander(design, rows.value, column_of(problem, &Row::weight).cwiseInverse(),
                                 column_of(problem, &Row::tau));
}

/// Pseudo-inverse of a symmetric matrix; `null` receives the directions without information.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix, Eigen::MatrixXd& null) {
  if (matrix.size() == 0) return matrix;
  const base::SymmetricEigen eigen = base::symmetric_eigen(matrix);
  const double floor = 1e-9 * std::max(1e-300, eigen.values.cwiseAbs().maxCoeff());
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(matrix.rows());
  std::vector<Eigen::Index> empty;
  for (Eigen::Index i = 0; i < inverse.size(); ++i) {
    if (eigen.values[i] > floor) {
      inverse[i] = 1.0 / eigen.values[i];
    } else {
      empty.push_back(i);
    }
  }
  null = eigen.vectors(Eigen::all, empty);
  return eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose();
}

/// The normal equations of the shared unknowns once each visit's own are eliminated (Schur complement).
SharedNormal eliminate_visits(const Problem& problem, const Normal& normal, double drift_variance,
                              std::vector<LocalMatrix>& inverse) {
  const std::size_t n = problem.visits.size();
  inverse.resize(n);
  SharedNormal reduced{normal.shared, normal.shared_right};
  for (std::size_t v = 0; v < n; ++v) {
    LocalMatrix own = normal.local[v].own;
    own(kDrift, kDrift) += 1.0 / drift_variance;
    if (!problem.visits[v].with_scale) own(kScale, kScale) = own(kBias, kBias);
    inverse[v] = base::inverse(own);
    reduced.matrix -= normal.local[v].cross.transpose() * inverse[v] * normal.local[v].cross;
    reduced.right -= normal.local[v].cross.transpose() * inverse[v] * normal.local[v].right;
  }
  return reduced;
}

/// Weighted least squares with a drift of variance `drift_variance` per visit: each visit's own unknowns are
/// eliminated, the shared ones solved, the rest substituted back.
Solution solve_with(const Problem& problem, const Normal& normal, double drift_variance) {
  const std::size_t n = problem.visits.size();
  std::vector<LocalMatrix> inverse;
  const SharedNormal reduced = eliminate_visits(problem, normal, drift_variance, inverse);
  Solution solution;
  solution.drift_variance = drift_variance;
  const Eigen::MatrixXd shared_covariance = pseudo_inverse(reduced.matrix, solution.open);
  solution.shared = shared_covariance * reduced.right;
  solution.shared_covariance = shared_covariance;
  for (std::size_t v = 0; v < n; ++v) {
    const Eigen::MatrixXd carry = inverse[v] * normal.local[v].cross;
    solution.local.push_back(inverse[v] * normal.local[v].right - carry * solution.shared);
    solution.local_variance.push_back(
        (LocalMatrix(inverse[v]) + LocalMatrix(carry * shared_covariance * carry.transpose())).diagonal());
    solution.bias_known.push_back(shows(solution, carry.row(kBias).transpose()));
    solution.scale_known.push_back(problem.visits[v].with_scale && shows(solution, carry.row(kScale).transpose()));
  }
  return solution;
}

/// Satterthwaite: ν = 2 v²/((dv/dq)² var q) of a variance v where that of the walk, q, is estimated, with v at q and a
/// hundredth beyond it; many where the walk hardly touches it.
double freedoms_of_wander(double variance, double wider, const SessionWander& wander) {
  constexpr double kMany = 1e6;
  const double per_variance = (wider - variance) / (kWanderStep * wander.variance);
  if (per_variance == 0.0 || variance <= 0.0) return kMany;
  return std::clamp(2.0 * variance * variance * wander.information / (per_variance * per_variance), 1.0, kMany);
}

void state_freedoms(const Problem& problem, const SessionWander& wander, Solution& solution) {
  solution.wander = wander.variance;
  if (wander.variance == 0.0) return;
  const Normal further = assemble(problem, (1.0 + kWanderStep) * wander.variance);
  const Solution wider = solve_with(problem, further, solution.drift_variance);
  const LocalVector& local = solution.local_variance.front();
  solution.wander_freedoms.bias = freedoms_of_wander(local[kBias], wider.local_variance.front()[kBias], wander);
  solution.wander_freedoms.scale = freedoms_of_wander(local[kScale], wider.local_variance.front()[kScale], wander);
  solution.wander_freedoms.shared = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < solution.shared.size(); ++k) {
    const double own = freedoms_of_wander(solution.shared_covariance(k, k), wider.shared_covariance(k, k), wander);
    solution.wander_freedoms.shared = std::min(solution.wander_freedoms.shared, own);
  }
}

void judge_residuals(const Problem& problem, Solution& solution, double drift_variance) {
  double chi_squared = 0.0;
  double unknowns = static_cast<double>(shared_count(problem));
  const Equations rows = whitened(problem, solution.wander);
  for (Eigen::Index i = 0; i < rows.value.size(); ++i) {
    const LocalVector& local = solution.local[problem.rows[static_cast<std::size_t>(i)].visit];
    const double fitted = rows.local.row(i).dot(local) + rows.shared.row(i).dot(solution.shared);
    chi_squared += (rows.value[i] - fitted) * (rows.value[i] - fitted);
  }
  for (std::size_t v = 0; v < problem.visits.size(); ++v) {
    const double drift = solution.local[v][kDrift];
    chi_squared += drift * drift / drift_variance;
    unknowns += problem.visits[v].with_scale ? 2.0 : 1.0;
  }
  const double degrees = static_cast<double>(problem.rows.size()) - unknowns;
  solution.reduced_chi_squared = degrees > 0.5 ? chi_squared / degrees : 0.0;
}

}  // namespace

Problem rows_of(std::span<const Segment> segments, Sensor sensor, const Place& place, const UnitType& type) {
  Problem problem;
  problem.sensor = sensor;
  problem.gravity_mps2 = place.gravity.mps2 * (is_gyro(sensor) ? 1 : type.sign_at_rest);
  problem.earth = place.earth;
  problem.azimuth_deg = place.azimuth_deg;
  problem.typical_se = typical_se(segments, sensor);
  problem.with_position =
      std::ranges::any_of(segments, [](const Segment& segment) { return segment.position.has_value(); });
  std::vector<const Segment*> kept;
  for (const Segment& segment : segments) {
    if (usable(segment, sensor) && segment.position.has_value() == problem.with_position) kept.push_back(&segment);
  }
  problem.reference_rate_rps = is_gyro(sensor) ? largest_rate_rps(kept, sensor) : 0.0;
  drop_lone_rates(kept, sensor, problem.reference_rate_rps);
  std::map<std::int32_t, std::size_t> index;
  problem.visits = collect_visits(kept, sensor, index);
  for (const Segment* segment : kept) problem.rows.push_back(row_of(*segment, problem, index[segment->key.visit]));
  normalise_times(problem);
  return problem;
}

Problem pose(Problem problem, const Tilt& tilt) {
  const bool gyro = is_gyro(problem.sensor);
  const std::size_t axis = axis_of(problem.sensor);
  for (Row& row : problem.rows) {
    row.value = row.mean;
    if (!row.position) continue;
    orient(row, problem.azimuth_deg, tilt);
    row.value -= known_part(problem, row);
    if (!gyro) row.scale_input = row.up[axis];
    if (gyro && row.rate_rps != 0.0) row.scale_input = row.rate_rps / problem.reference_rate_rps;
  }
  choose_scales(problem);
  if (problem.with_position && gyro) choose_nuisances(problem);
  problem.with_even = problem.with_position && !gyro;
  problem.with_contrast = problem.with_even && both_ways(problem, (axis + 1) % 3) && both_ways(problem, (axis + 2) % 3);
  return problem;
}

bool shows(const Solution& solution, const Eigen::VectorXd& weights) {
  return solution.open.size() == 0 || (weights.transpose() * solution.open).cwiseAbs().maxCoeff() < kOpen;
}

double inflation_of(const Problem& problem, const Solution& solution) {
  const double least = problem.typical_se > 0.0 ? 1.0 : 0.0;
  return std::sqrt(std::max(least, solution.reduced_chi_squared));
}

SharedNormal shared_normal(const Problem& problem, double drift_variance) {
  std::vector<LocalMatrix> inverse;
  return eliminate_visits(problem, assemble(problem, 0.0), drift_variance, inverse);
}

Solution solve(const Problem& problem) {
  const SessionWander wander = wander_of(problem);
  const Normal normal = assemble(problem, wander.variance);
  const double unit = problem.typical_se > 0.0 ? problem.typical_se * problem.typical_se : 1.0;
  double drift_variance = unit;
  Solution solution = solve_with(problem, normal, drift_variance);
  for (int i = 0; i < kDriftIterations; ++i) {
    double sum = 0.0;
    for (std::size_t v = 0; v < problem.visits.size(); ++v) {
      sum += solution.local[v][kDrift] * solution.local[v][kDrift] + solution.local_variance[v][kDrift];
    }
    drift_variance = std::max(1e-6 * unit, sum / static_cast<double>(problem.visits.size()));
    solution = solve_with(problem, normal, drift_variance);
  }
  state_freedoms(problem, wander, solution);
  judge_residuals(problem, solution, drift_variance);
  return solution;
}

}  // namespace soak::calib::six_position
