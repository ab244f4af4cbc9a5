// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/statistics.h"
#include "base/units.h"
#include "calib/segments/statistics.h"

namespace soak::calib::six_position {
namespace {

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

double largest_rate_rps(std::span<const Segment> segments, Sensor sensor) {
  double largest = 0.0;
  for (const Segment& segment : segments) largest = std::max(largest, std::abs(rate_rps(segment, sensor)));
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
void drop_lone_rates(std::vector<Segment>& segments, Sensor sensor, double reference_rate_rps) {
  std::map<std::int32_t, Range> rates;
  for (const Segment& segment : segments) rates[segment.key.visit].add(rate_rps(segment, sensor));
  std::erase_if(segments, [&](const Segment& segment) {
    return turns(segment) && rates[segment.key.visit].span() < kScaleSpan * reference_rate_rps;
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

/// What is known of the reading beforehand: gravity on accelerometers, the Earth's rate on gyros.
double known_part(const Problem& problem, const Row& row, const EarthRate& earth) {
  const std::size_t axis = axis_of(problem.sensor);
  if (!is_gyro(problem.sensor)) return problem.gravity_mps2 * row.up[axis];
  return earth.vertical_rps * row.up[axis] + earth.horizontal_rps * row.north[axis];
}

/// Where the axes of the unit point: as the position says, tilted and with north and east where the headings are known.
/// A unit that turns sees the tilts of whole turns cancel.
void orient(Row& row, const Segment& segment, const Circumstances& circumstances) {
  row.up = segment.position->up;
  if (!circumstances.azimuth_deg || turns(segment)) return;
  const Frame frame = frame_of(*segment.position, *circumstances.azimuth_deg, circumstances.tilt);
  row.up = frame.up;
  row.north = frame.north;
  row.east = frame.east;
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

Row row_of(const Segment& segment, const Problem& problem, std::size_t visit, const Circumstances& circumstances) {
  const Sensor sensor = problem.sensor;
  const SensorStatistics& statistics = segment.sensor[index_of(sensor)];
  const double se = pooled_se(statistics, problem.typical_se);
  Row row{.visit = visit,
          .value = statistics.mean,
          .weight = 1.0 / (se * se),
          .temp_c = segment.sensor_temp_c[index_of(sensor)],
          .tau = 0.5 * (segment.t_start_s + segment.t_end_s) - problem.visits[visit].t_s,
          .up = {},
          .north = {},
          .east = {},
          .label = segment.key.position,
          .scale_input = 0.0};
  if (!segment.position) return row;
  const double rate = rate_rps(segment, sensor);
  orient(row, segment, circumstances);
  row.value -= known_part(problem, row, circumstances.earth) + (is_gyro(sensor) ? rate : 0.0);
  row.scale_input = is_gyro(sensor) ? (rate == 0.0 ? 0.0 : rate / problem.reference_rate_rps) : row.up[axis_of(sensor)];
  return row;
}

/// Times from the middles of the visits in units of the longest.
void normalise_times(Problem& problem) {
  double longest = 0.0;
  for (const Row& row : problem.rows) longest = std::max(longest, std::abs(row.tau));
  if (longest == 0.0) return;
  for (Row& row : problem.rows) row.tau /= longest;
}

}  // namespace

Problem pose(std::span<const Segment> segments, Sensor sensor, const Circumstances& circumstances) {
  Problem problem;
  problem.sensor = sensor;
  problem.gravity_mps2 = circumstances.gravity_mps2 * (is_gyro(sensor) ? 1 : circumstances.sign_at_rest);
  problem.typical_se = typical_se(segments, sensor);
  problem.with_position =
      std::any_of(segments.begin(), segments.end(), [](const Segment& s) { return s.position.has_value(); });
  std::vector<Segment> kept;
  for (const Segment& segment : segments) {
    if (usable(segment, sensor) && segment.position.has_value() == problem.with_position) kept.push_back(segment);
  }
  problem.reference_rate_rps = is_gyro(sensor) ? largest_rate_rps(kept, sensor) : 0.0;
  drop_lone_rates(kept, sensor, problem.reference_rate_rps);
  std::map<std::int32_t, std::size_t> index;
  problem.visits = collect_visits(kept, sensor, index);
  for (const Segment& segment : kept) {
    problem.rows.push_back(row_of(segment, problem, index[segment.key.visit], circumstances));
  }
  normalise_times(problem);
  choose_scales(problem);
  if (problem.with_position && is_gyro(sensor)) choose_nuisances(problem);
  problem.with_even = problem.with_position && !is_gyro(sensor);
  const std::size_t axis = axis_of(sensor);
  problem.with_contrast = problem.with_even && both_ways(problem, (axis + 1) % 3) && both_ways(problem, (axis + 2) % 3);
  return problem;
}

}  // namespace soak::calib::six_position
