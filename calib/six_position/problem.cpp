// SPDX-License-Identifier: Apache-2.0
#include "calib/six_position/problem.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/statistics.h"
#include "calib/statistics.h"

namespace soak::calib::six_position {
namespace {

constexpr double kScaleSpan = 0.5;         ///< spread of up_i within a visit from which its scale is observable
constexpr double kPoolingStrength = 20.0;  ///< prior degrees of freedom of the run's typical standard error

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

/// What is known of the reading beforehand: gravity on accelerometers, the vertical part of the Earth's rate on gyros.
double known_part(const Problem& problem, const Vector3& up, double vertical_rate_rps) {
  const double up_i = up[axis_of(problem.sensor)];
  return is_gyro(problem.sensor) ? vertical_rate_rps * up_i : problem.gravity_mps2 * up_i;
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
      row.value -= known_part(problem, row.up, circumstances.vertical_rate_rps);
    }
    problem.rows.push_back(std::move(row));
  }
  choose_unknowns(problem);
  return problem;
}

}  // namespace soak::calib::six_position
