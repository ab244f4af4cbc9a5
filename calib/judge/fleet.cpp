// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/fleet.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"

namespace soak::calib {
namespace {

constexpr double kStep_c = 5.0;
constexpr double kHeldFor_c = 0.5 * kStep_c;
/// Median absolute deviation → standard deviation, of normal values: 1/Φ⁻¹(3/4).
constexpr double kPerMad = 1.4826;
/// Chance that a unit which has not moved is said to have moved.
constexpr double kFalseAlarm = 0.05;

/// Value and band at a temperature; nothing where the curve does not reach.
std::optional<FleetPoint> at(const FleetCurve& curve, double temp_c) {
  if (curve.empty()) return std::nullopt;
  if (temp_c < curve.front().temp_c - kHeldFor_c || temp_c > curve.back().temp_c + kHeldFor_c) return std::nullopt;
  const auto above = std::ranges::lower_bound(curve, temp_c, {}, &FleetPoint::temp_c);
  if (above == curve.begin()) return curve.front();
  if (above == curve.end()) return curve.back();
  const FleetPoint& below = *(above - 1);
  const double share = (temp_c - below.temp_c) / (above->temp_c - below.temp_c);
  return FleetPoint{temp_c, std::lerp(below.value, above->value, share), std::lerp(below.ci95, above->ci95, share)};
}

/// Multiples of the step within reach of the curves: one at least, as every curve reaches over a whole step.
std::vector<double> temperatures_of(const std::vector<FleetMember>& members) {
  double low_c = std::numeric_limits<double>::infinity();
  double high_c = -low_c;
  for (const FleetMember& member : members) {
    if (member.newest.empty()) continue;
    low_c = std::min(low_c, member.newest.front().temp_c - kHeldFor_c);
    high_c = std::max(high_c, member.newest.back().temp_c + kHeldFor_c);
  }
  std::vector<double> temps_c;
  if (low_c > high_c) return temps_c;
  const auto last = static_cast<int>(std::floor(high_c / kStep_c));
  for (auto k = static_cast<int>(std::ceil(low_c / kStep_c)); k <= last; ++k) temps_c.push_back(k * kStep_c);
  return temps_c;
}

/// Median and spread at one temperature.
struct Level {
  std::optional<double> median;
  std::optional<double> spread;
};

Level level_of(const std::vector<FleetPoint>& points, std::size_t curves) {
  if (points.empty() || 2 * points.size() < curves) return {};
  std::vector<double> values;
  std::vector<double> halves;
  for (const FleetPoint& point : points) {
    values.push_back(point.value);
    halves.push_back(0.5 * point.ci95);
  }
  const double median = base::median(values);
  if (points.size() < kFewestForSpread) return {median, std::nullopt};
  for (double& value : values) value = std::abs(value - median);
  return {median, std::max(kPerMad * base::median(values), base::median(halves))};
}

void judge_distance(const FleetSpread& fleet, FleetPlace& unit) {
  double squares = 0.0;
  double count = 0.0;
  double farthest = -1.0;
  for (std::size_t t = 0; t < fleet.temp_c.size(); ++t) {
    if (!unit.values[t] || !fleet.spread[t] || !(*fleet.spread[t] > 0.0)) continue;
    const double off = std::abs(*unit.values[t] - *fleet.median[t]) / *fleet.spread[t];
    squares += off * off;
    count += 1.0;
    if (off <= farthest) continue;
    farthest = off;
    unit.farthest_c = fleet.temp_c[t];
  }
  if (count > 0.0) unit.distance = std::sqrt(squares / count);
}

/// A normal value lies further off than this many standard deviations with that chance, either way.
double normal_two_sided(double chance) { return std::sqrt(base::chi_squared_quantile(1.0 - chance, 1.0)); }

std::optional<FleetDrift> drift_of(const FleetMember& member, const std::vector<double>& temps_c) {
  std::optional<FleetDrift> most;
  double comparisons = 0.0;
  for (const double temp_c : temps_c) {
    const auto now = at(member.newest, temp_c);
    const auto then = at(member.before, temp_c);
    if (!now || !then) continue;
    comparisons += static_cast<double>(member.curves);
    const FleetDrift drift{temp_c, now->value - then->value, std::hypot(now->ci95, then->ci95)};
    // |change|/band compared crosswise: a band may be 0.
    if (!most || std::abs(drift.change) * most->band > std::abs(most->change) * drift.band) most = drift;
  }
  if (most) most->band *= normal_two_sided(kFalseAlarm / comparisons) / normal_two_sided(kFalseAlarm);
  return most;
}

}  // namespace

bool FleetPlace::is_outlier() const { return distance && *distance > kOutlierDistance; }

FleetSpread compare_fleet(const std::vector<FleetMember>& members) {
  FleetSpread fleet;
  fleet.temp_c = temperatures_of(members);
  fleet.units.resize(members.size());
  const auto curves = static_cast<std::size_t>(
      std::ranges::count_if(members, [](const FleetMember& member) { return !member.newest.empty(); }));
  for (const double temp_c : fleet.temp_c) {
    std::vector<FleetPoint> points;
    for (std::size_t u = 0; u < members.size(); ++u) {
      const auto point = at(members[u].newest, temp_c);
      fleet.units[u].values.push_back(point ? std::optional(point->value) : std::nullopt);
      if (point) points.push_back(*point);
    }
    const Level level = level_of(points, curves);
    fleet.median.push_back(level.median);
    fleet.spread.push_back(level.spread);
  }
  for (std::size_t u = 0; u < members.size(); ++u) {
    judge_distance(fleet, fleet.units[u]);
    fleet.units[u].drift = drift_of(members[u], fleet.temp_c);
  }
  return fleet;
}

}  // namespace soak::calib
