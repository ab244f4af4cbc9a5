// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "base/statistics.h"
#include "base/units.h"
#include "calib/segments/detail/gate.h"

namespace soak::calib::gate {
namespace {

constexpr double kTurnStretch_s = 10.0;  ///< that GateLimits::turn_deg is meant for
/// Distance in temperature from which the change of a bias over it can be told from noise.
constexpr double kLeastChange_c = 2.0;
constexpr double kLargestDrift_mps2pk = 0.03;  ///< 3 mg/K: no accelerometer drifts faster
/// Rate by which a gyro may differ between positions at one temperature: g-sensitivity of 0.1-0.2 deg/s per g, drift.
constexpr double kPositionRate_dps = 0.5;
constexpr std::size_t kFewestRests = 4;  ///< to tell which of them differs
constexpr std::array kAccels = {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z};
constexpr std::array kGyros = {Sensor::gyro_x, Sensor::gyro_y, Sensor::gyro_z};

/// Mean specific force and temperature of one stretch.
struct Rest {
  double t_s = 0.0;
  Vector3 force{};
  double temp_c = 0.0;
};

/// Standard error of a stretch's mean, from the scatter of the means m themselves: median|m_(i+1) − m_i| / (0.6745·√2),
/// which a few moves do not touch; at least that of white noise, and no more than kLargestInflation times it.
double mean_error(const std::vector<double>& means, double white) {
  constexpr double kLargestInflation = 30.0;
  constexpr double kQuartile = 0.6745;  ///< of the standard normal distribution
  std::vector<double> steps;
  for (std::size_t i = 1; i < means.size(); ++i) steps.push_back(std::abs(means[i] - means[i - 1]));
  std::erase_if(steps, [](double step) { return std::isnan(step); });
  if (steps.empty()) return white;
  return std::clamp(base::median(steps) / (kQuartile * std::numbers::sqrt2), white, kLargestInflation * white);
}

/// How far the mean of a sensor may jump because of its output step: noise of half a step averages that away. Larger
/// jumps than that of a coarse sensor are none.
double rounding_of(const View& view, Sensor sensor) {
  constexpr double kCoarseAccel_mps2 = 0.05;
  constexpr double kCoarseGyro_dps = 1.5;
  const SensorFacts& facts = view.facts_of(sensor);
  const double step = step_of(view, sensor);
  if (facts.many_codes && facts.noise >= 0.5 * step) return 0.0;
  return std::min(step, is_gyro(sensor) ? kCoarseGyro_dps / base::kDegPerRad : kCoarseAccel_mps2);
}

double norm_of(const Vector3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

Vector3 difference(const Vector3& a, const Vector3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Angle between two vectors, degrees: atan2(|a × b|, a · b).
double angle_between_deg(const Vector3& a, const Vector3& b) {
  const Vector3 cross = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  return base::kDegPerRad * std::atan2(norm_of(cross), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

bool recorded(const View& view, Sensor sensor) { return view.summary_of(sensor).recorded; }

bool all_recorded(const View& view) {
  return std::all_of(kAccels.begin(), kAccels.end(), [&](Sensor sensor) { return recorded(view, sensor); });
}

/// Axes that are not recorded read 0.
std::optional<Rest> rest_in(const View& view, std::size_t index) {
  const Stretch& stretch = view.state.stretches[index];
  Rest rest{view.t_s()[stretch.first], {}, 0.0};
  for (std::size_t i = 0; i < 3; ++i) {
    if (recorded(view, kAccels[i])) rest.force[i] = view.levels_of(kAccels[i]).mean[index];
  }
  if (!view.temp_c().empty()) {
    rest.temp_c = mean_of(view.temp_c().subspan(stretch.first, stretch.last - stretch.first));
  }
  if (std::isnan(norm_of(rest.force)) || norm_of(rest.force) <= 0.0) return std::nullopt;
  return rest;
}

std::vector<Rest> rests_of(const View& view) {
  std::vector<Rest> rests;
  for (std::size_t i = 0; i < view.state.stretches.size(); ++i) {
    if (const auto rest = rest_in(view, i)) rests.push_back(*rest);
  }
  return rests;
}

/// Change of an accelerometer per kelvin: the median over pairs of stretches a quarter of the segment apart, of which
/// a move falls into a third. 0 where most of them differ by too little temperature to tell.
double change_per_k(const std::vector<Rest>& rests, std::size_t axis) {
  const std::size_t apart = std::max<std::size_t>(1, rests.size() / 4);
  std::vector<double> slopes;
  for (std::size_t i = 0; i + apart < rests.size(); ++i) {
    const double change_c = rests[i + apart].temp_c - rests[i].temp_c;
    if (!(std::abs(change_c) >= kLeastChange_c)) continue;
    slopes.push_back((rests[i + apart].force[axis] - rests[i].force[axis]) / change_c);
  }
  if (2 * slopes.size() < rests.size() - apart) return 0.0;
  return std::clamp(base::median(slopes), -kLargestDrift_mps2pk, kLargestDrift_mps2pk);
}

/// Takes off what follows the temperature in proportion: on a ramp the bias may move by degrees of apparent tilt.
void remove_drift(std::vector<Rest>& rests) {
  const double reference_c = rests.front().temp_c;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double slope = change_per_k(rests, axis);
    if (slope == 0.0) continue;
    for (Rest& rest : rests) {
      if (!std::isnan(rest.temp_c)) rest.force[axis] -= slope * (rest.temp_c - reference_c);
    }
  }
}

/// Component by component the middle of all stretches.
Rest middle_of(const std::vector<Rest>& rests) {
  Rest middle = rests.front();
  std::vector<double> values(rests.size());
  const auto median = [&](auto&& member) {
    std::transform(rests.begin(), rests.end(), values.begin(), member);
    std::erase_if(values, [](double v) { return std::isnan(v); });
    const double middle = base::median(values);
    values.resize(rests.size());
    return middle;
  };
  for (std::size_t i = 0; i < 3; ++i) middle.force[i] = median([i](const Rest& rest) { return rest.force[i]; });
  middle.temp_c = median([](const Rest& rest) { return rest.temp_c; });
  return middle;
}

/// A change of direction beyond what noise and temperature explain.
struct AttitudeChange {
  double excess_deg = 0.0;  ///< over the limit
  double angle_deg = 0.0;
  double limit_deg = 0.0;
  double t_s = 0.0;
};

/// Largest standard error of the three accelerometers' means.
double force_error(const View& view, const std::vector<Rest>& rests) {
  const double samples = static_cast<double>(view.rows()) / static_cast<double>(rests.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    std::vector<double> means;
    for (const Rest& rest : rests) means.push_back(rest.force[i]);
    largest = std::max(largest, mean_error(means, view.facts_of(kAccels[i]).noise / std::sqrt(samples)));
  }
  return largest;
}

/// Largest output step that shows in the means of an accelerometer.
double coarsest(const View& view) {
  double step = 0.0;
  for (const Sensor sensor : kAccels) step = std::max(step, rounding_of(view, sensor));
  return step;
}

/// limit = tilt + tilt_per_k·|ΔT| + (z·√2·σ + q)/|f|: noise of the difference of two means across the force. Where not
/// all three accelerometers are there, their change stands as the least angle that explains it: |Δf|/g.
AttitudeChange tilt_between(const View& view, const Rest& a, const Rest& b, double error) {
  const bool whole = all_recorded(view);
  const double noise = view.limits.noise_sigmas * std::numbers::sqrt2 * error + coarsest(view);
  const double noise_deg = base::kDegPerRad * noise / (whole ? norm_of(a.force) : base::kStandardGravity_mps2);
  const double temp_change_c = std::isnan(a.temp_c - b.temp_c) ? 0.0 : std::abs(a.temp_c - b.temp_c);
  AttitudeChange tilt;
  tilt.angle_deg = whole ? angle_between_deg(a.force, b.force)
                         : base::kDegPerRad * norm_of(difference(a.force, b.force)) / base::kStandardGravity_mps2;
  tilt.limit_deg = view.limits.tilt_deg + view.limits.tilt_per_k_deg * temp_change_c + noise_deg;
  tilt.excess_deg = tilt.angle_deg - tilt.limit_deg;
  tilt.t_s = b.t_s;
  return tilt;
}

/// Whether the temperature runs so far through a segment that its middle says nothing of its ends: curve and memory of
/// the accelerometers come and go with it.
bool is_ramp(const View& view, const std::vector<Rest>& rests) {
  constexpr double kRamp_c = 10.0;
  if (view.segment.plateau_c) return false;
  double low_c = std::numeric_limits<double>::infinity();
  double high_c = -low_c;
  for (const Rest& rest : rests) {
    if (std::isnan(rest.temp_c)) continue;
    low_c = std::min(low_c, rest.temp_c);
    high_c = std::max(high_c, rest.temp_c);
  }
  return high_c - low_c > kRamp_c;
}

/// The worst of: each stretch against the middle of all, but on ramps, and against the last but one before it (a step
/// may lie within the stretch between them).
std::optional<AttitudeChange> worst_tilt(const View& view) {
  if (std::none_of(kAccels.begin(), kAccels.end(), [&](Sensor s) { return recorded(view, s); })) return std::nullopt;
  std::vector<Rest> rests = rests_of(view);
  if (rests.size() < 3) return std::nullopt;
  const bool ramp = is_ramp(view, rests);
  remove_drift(rests);
  const Rest middle = middle_of(rests);
  if (norm_of(middle.force) <= 0.0) return std::nullopt;
  const double error = force_error(view, rests);
  AttitudeChange worst;
  const auto keep = [&](const AttitudeChange& tilt) {
    if (tilt.excess_deg > worst.excess_deg) worst = tilt;
  };
  for (std::size_t i = 0; i < rests.size(); ++i) {
    if (!ramp) keep(tilt_between(view, middle, rests[i], error));
    if (i >= 2) keep(tilt_between(view, rests[i - 2], rests[i], error));
  }
  return worst.excess_deg > 0.0 ? std::optional(worst) : std::nullopt;
}

/// An angle that a gyro turned through within a stretch.
struct Turn {
  Sensor sensor = Sensor::gyro_x;
  double excess_deg = 0.0;
  double angle_deg = 0.0;
  double limit_deg = 0.0;
  double t_s = 0.0;
};

/// Angle = (mean rate − that of the stretches two away) · duration; the limit grows with longer stretches, as drift
/// does.
Turn turn_in(const View& view, Sensor sensor, const std::vector<Stretch>& all, const std::vector<double>& rates,
             std::size_t i) {
  std::vector<double> around;
  if (i >= 2 && !std::isnan(rates[i - 2])) around.push_back(rates[i - 2]);
  if (i + 2 < rates.size() && !std::isnan(rates[i + 2])) around.push_back(rates[i + 2]);
  Turn turn;
  if (around.empty() || std::isnan(rates[i])) return turn;
  const double duration_s = all[i].duration_s;
  const double white = view.facts_of(sensor).noise / std::sqrt(static_cast<double>(all[i].last - all[i].first));
  const double error_rps = std::numbers::sqrt2 * mean_error(rates, white);
  turn.sensor = sensor;
  turn.angle_deg = base::kDegPerRad * std::abs(rates[i] - mean_of(around)) * duration_s;
  turn.limit_deg = view.limits.turn_deg * std::max(1.0, duration_s / kTurnStretch_s) +
                   base::kDegPerRad * (view.limits.noise_sigmas * error_rps + rounding_of(view, sensor)) * duration_s;
  turn.excess_deg = turn.angle_deg - turn.limit_deg;
  turn.t_s = view.t_s()[all[i].first];
  return turn;
}

std::optional<Turn> worst_turn(const View& view) {
  Turn worst;
  for (const Sensor sensor : kGyros) {
    const std::vector<double>& rates = view.levels_of(sensor).mean;
    for (std::size_t i = 0; i < rates.size(); ++i) {
      const Turn turn = turn_in(view, sensor, view.state.stretches, rates, i);
      if (turn.excess_deg > worst.excess_deg) worst = turn;
    }
  }
  return worst.excess_deg > 0.0 ? std::optional(worst) : std::nullopt;
}

/// Means of a gyro in all segments of the same visit in which the fixture rests.
std::vector<double> rates_of_visit(const View& view, Sensor sensor) {
  std::vector<double> rates;
  for (const Segment& segment : view.segments) {
    const SensorStatistics& statistics = segment.sensor[index_of(sensor)];
    if (segment.key.visit == view.segment.key.visit && statistics.count > 0 && !turns(segment)) {
      rates.push_back(statistics.mean);
    }
  }
  return rates;
}

/// Rate about the vertical through the whole segment, which no accelerometer and no stretch shows.
std::optional<Finding> steady_turn(const View& view) {
  if (turns(view.segment)) return std::nullopt;
  for (const Sensor sensor : kGyros) {
    const SensorStatistics& statistics = view.segment.sensor[index_of(sensor)];
    const std::vector<double> rates = rates_of_visit(view, sensor);
    if (statistics.count == 0 || rates.size() < kFewestRests) continue;
    const double off_dps = base::kDegPerRad * std::abs(statistics.mean - base::median(rates));
    const double noise_dps = base::kDegPerRad * view.limits.noise_sigmas * statistics.standard_error;
    if (off_dps <= kPositionRate_dps + noise_dps) continue;
    return Finding{"moved", Severity::warn, std::nullopt,
                   fmt::format("{} reads {:.2f} deg/s away from its median over the visit's positions (up to {:.2f} "
                               "deg/s are usual): the unit was turning the whole time, or its g-sensitivity is large",
                               name_of(sensor), off_dps, kPositionRate_dps + noise_dps)};
  }
  return std::nullopt;
}

// Knocks.

/// A knock that shifts a mean by more standard errors of its noise than this spoils the segment.
constexpr double kTolerableShift = 3.0;

/// Knocks of a segment: bursts of hits in several sensors.
struct Knocks {
  int count = 0;
  double first_s = 0.0;
  std::vector<std::size_t> rows;
};

/// Rows that are hit in any sensor, rising.
std::vector<std::size_t> rows_hit(const View& view) {
  std::vector<std::size_t> rows;
  for (const SensorSummary& summary : view.state.sensor) {
    for (const Hit& hit : summary.levels.hits) rows.push_back(hit.row);
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

/// Rows from `first` on whose hits follow each other within kBurstGap_s or from row to row.
std::vector<std::size_t> burst_from(const View& view, const std::vector<std::size_t>& hits, std::size_t first) {
  const double near_s =
      std::max(kBurstGap_s, 1.5 * (view.t_s().back() - view.t_s().front()) / static_cast<double>(view.rows()));
  std::vector<std::size_t> burst = {hits[first]};
  for (std::size_t i = first + 1; i < hits.size() && view.t_s()[hits[i]] - view.t_s()[burst.back()] <= near_s; ++i) {
    burst.push_back(hits[i]);
  }
  return burst;
}

int sensors_hit(const View& view, const std::vector<std::size_t>& burst) {
  const auto& sensors = view.state.sensor;
  return static_cast<int>(std::count_if(sensors.begin(), sensors.end(), [&](const SensorSummary& summary) {
    const Levels& levels = summary.levels;
    const auto hit = std::lower_bound(levels.hits.begin(), levels.hits.end(), burst.front(),
                                      [](const Hit& h, std::size_t row) { return h.row < row; });
    return hit != levels.hits.end() && hit->row <= burst.back();
  }));
}

Knocks find_knocks(const View& view) {
  const std::vector<std::size_t> hits = rows_hit(view);
  Knocks knocks;
  for (std::size_t first = 0; first < hits.size();) {
    const std::vector<std::size_t> burst = burst_from(view, hits, first);
    first += burst.size();
    if (sensors_hit(view, burst) < view.limits.knock_sensors) continue;
    if (knocks.count++ == 0) knocks.first_s = view.t_s()[burst.front()];
    knocks.rows.insert(knocks.rows.end(), burst.begin(), burst.end());
  }
  return knocks;
}

/// Largest shift of a sensor's mean by its hits among `rows`, in standard errors of its white noise: Σ r / (σ √n).
double shift_of(const View& view, const std::vector<std::size_t>& rows) {
  double largest = 0.0;
  for (const Sensor sensor : kSensors) {
    const Levels& levels = view.levels_of(sensor);
    double sum = 0.0;
    for (const Hit& hit : levels.hits) {
      if (std::binary_search(rows.begin(), rows.end(), hit.row)) sum += hit.residual;
    }
    const auto samples = static_cast<double>(view.summary_of(sensor).samples);
    if (sum != 0.0) largest = std::max(largest, std::abs(sum) / (levels.sigma * std::sqrt(samples)));
  }
  return largest;
}

}  // namespace

void moved(const View& view, std::vector<Finding>& findings) {
  if (const auto tilt = worst_tilt(view)) {
    findings.push_back({"moved", Severity::reject, std::nullopt,
                        fmt::format("the direction of the specific force changes by {:.2f} deg at {:.1f} s; at rest it "
                                    "stays within {:.2f} deg: the unit was moved or the segment begins too early",
                                    tilt->angle_deg, tilt->t_s, tilt->limit_deg)});
  } else if (const auto turn = worst_turn(view)) {
    findings.push_back(
        {"moved", Severity::reject, std::nullopt,
         fmt::format("{} turns through {:.1f} deg at {:.1f} s; at rest it stays within {:.1f} deg: the unit was turned",
                     name_of(turn->sensor), turn->angle_deg, turn->t_s, turn->limit_deg)});
  } else if (const auto finding = steady_turn(view)) {
    findings.push_back(*finding);
  }
}

void knocked(const View& view, std::vector<Finding>& findings) {
  if (rejected_as(findings, "moved")) return;
  const Knocks knocks = find_knocks(view);
  if (knocks.count == 0) return;
  const double shift = shift_of(view, knocks.rows);
  findings.push_back({"knocked", shift > kTolerableShift ? Severity::reject : Severity::warn, std::nullopt,
                      fmt::format("{} burst{} beyond {:.0f} sigma in several sensors at once, the first at {:.2f} s, "
                                  "shift a mean by {:.1f} standard errors of its noise (up to {:.0f} are tolerable)",
                                  knocks.count, knocks.count == 1 ? "" : "s", view.limits.knock_sigmas, knocks.first_s,
                                  shift, kTolerableShift)});
}

}  // namespace soak::calib::gate
