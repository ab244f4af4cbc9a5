// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/statistics.h"
#include "base/units.h"
#include "calib/gate/checks.h"

namespace soak::calib::gate {
namespace {

constexpr double kTurnStretch_s = 10.0;  ///< that GateLimits::turn_deg is meant for
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
  const std::vector<double> known = present(steps);
  if (known.empty()) return white;
  return std::clamp(base::median(known) / (kQuartile * std::numbers::sqrt2), white, kLargestInflation * white);
}

double norm_of(const Vector3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/// Angle between two vectors, degrees: atan2(|a × b|, a · b).
double angle_deg(const Vector3& a, const Vector3& b) {
  const Vector3 cross = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  return base::kDegPerRad * std::atan2(norm_of(cross), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

std::optional<Rest> rest_in(const View& view, const Stretch& stretch) {
  const std::size_t length = stretch.last - stretch.first;
  Rest rest{view.t_s()[stretch.first], {}, 0.0};
  for (std::size_t i = 0; i < 3; ++i) rest.force[i] = mean_of(view.values(kAccels[i]).subspan(stretch.first, length));
  rest.temp_c = view.temp_c().empty() ? 0.0 : mean_of(view.temp_c().subspan(stretch.first, length));
  if (std::isnan(norm_of(rest.force)) || norm_of(rest.force) <= 0.0) return std::nullopt;
  return rest;
}

std::vector<Rest> rests_of(const View& view) {
  std::vector<Rest> rests;
  for (const Stretch& stretch : stretches(view.t_s())) {
    if (const auto rest = rest_in(view, stretch)) rests.push_back(*rest);
  }
  return rests;
}

/// Component by component the middle of all stretches.
Rest middle_of(const std::vector<Rest>& rests) {
  Rest middle = rests.front();
  std::vector<double> values(rests.size());
  const auto median = [&](auto&& member) {
    std::transform(rests.begin(), rests.end(), values.begin(), member);
    return base::median(present(values));
  };
  for (std::size_t i = 0; i < 3; ++i) middle.force[i] = median([i](const Rest& rest) { return rest.force[i]; });
  middle.temp_c = median([](const Rest& rest) { return rest.temp_c; });
  return middle;
}

/// A change of direction beyond what noise and temperature explain.
struct Tilt {
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

/// limit = tilt + tilt_per_k·|ΔT| + z·√2·σ/|f|: noise of the difference of two means across the force.
Tilt compare(const View& view, const Rest& a, const Rest& b, double error) {
  const double noise_deg = base::kDegPerRad * std::numbers::sqrt2 * error / norm_of(a.force);
  const double temp_change_c = std::isnan(a.temp_c - b.temp_c) ? 0.0 : std::abs(a.temp_c - b.temp_c);
  Tilt tilt;
  tilt.angle_deg = angle_deg(a.force, b.force);
  tilt.limit_deg =
      view.limits.tilt_deg + view.limits.tilt_per_k_deg * temp_change_c + view.limits.noise_sigmas * noise_deg;
  tilt.excess_deg = tilt.angle_deg - tilt.limit_deg;
  tilt.t_s = b.t_s;
  return tilt;
}

/// The worst of: each stretch against the middle of all, and against the last but one before it (a step may lie within
/// the stretch between them).
std::optional<Tilt> worst_tilt(const View& view) {
  for (const Sensor sensor : kAccels) {
    if (view.values(sensor).empty()) return std::nullopt;
  }
  const std::vector<Rest> rests = rests_of(view);
  if (rests.size() < 3) return std::nullopt;
  const Rest middle = middle_of(rests);
  if (norm_of(middle.force) <= 0.0) return std::nullopt;
  const double error = force_error(view, rests);
  Tilt worst;
  const auto keep = [&](const Tilt& tilt) {
    if (tilt.excess_deg > worst.excess_deg) worst = tilt;
  };
  for (std::size_t i = 0; i < rests.size(); ++i) {
    keep(compare(view, middle, rests[i], error));
    if (i >= 2) keep(compare(view, rests[i - 2], rests[i], error));
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
                   view.limits.noise_sigmas * base::kDegPerRad * error_rps * duration_s;
  turn.excess_deg = turn.angle_deg - turn.limit_deg;
  turn.t_s = view.t_s()[all[i].first];
  return turn;
}

std::optional<Turn> worst_turn(const View& view) {
  const std::vector<Stretch> all = stretches(view.t_s());
  Turn worst;
  for (const Sensor sensor : kGyros) {
    if (view.values(sensor).empty()) continue;
    std::vector<double> rates;
    for (const Stretch& stretch : all) {
      rates.push_back(mean_of(view.values(sensor).subspan(stretch.first, stretch.last - stretch.first)));
    }
    for (std::size_t i = 0; i < rates.size(); ++i) {
      const Turn turn = turn_in(view, sensor, all, rates, i);
      if (turn.excess_deg > worst.excess_deg) worst = turn;
    }
  }
  return worst.excess_deg > 0.0 ? std::optional(worst) : std::nullopt;
}

}  // namespace

void moved(const View& view, std::vector<Finding>& findings) {
  if (const auto tilt = worst_tilt(view)) {
    findings.push_back({"moved", Severity::reject, std::nullopt,
                        fmt::format("the direction of the specific force changes by {:.2f} deg at {:.1f} s; at rest it "
                                    "stays within {:.2f} deg: the unit was moved or the segment begins too early",
                                    tilt->angle_deg, tilt->t_s, tilt->limit_deg)});
  } else if (const auto turn = worst_turn(view)) {
    findings.push_back({"moved", Severity::reject, std::nullopt,
                        fmt::format("{} turns through {:.1f} deg at {:.1f} s; at rest it stays within {:.1f} deg: the "
                                    "unit was turned",
                                    name_of(turn->sensor), turn->angle_deg, turn->t_s, turn->limit_deg)});
  }
}

}  // namespace soak::calib::gate
