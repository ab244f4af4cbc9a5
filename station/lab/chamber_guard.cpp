// SPDX-License-Identifier: Apache-2.0
#include "station/lab/chamber_guard.h"

#include <fmt/format.h>

#include <cmath>

namespace soak::station {
namespace {

constexpr double kRatingMargin_c = 5.0;  ///< thermometers of units are 1 to 3 K off
constexpr double kFastest_kpmin = 20.0;  ///< twice what the quickest chambers for units do
constexpr double kFastWindow_s = 60.0;
constexpr double kApart_c = 25.0;      ///< units warm themselves by up to 15 K
constexpr double kSettled_s = 1800.0;  ///< of the air at its set point
constexpr double kAtSetPoint_c = 2.0;
constexpr double kOutputOn_percent = 5.0;
constexpr double kOutputRunAway_percent = 90.0;
constexpr double kStanding_s = 600.0;
constexpr std::chrono::seconds kStandingHost{5};
constexpr double kFullHeating_percent = 95.0;
constexpr double kFullHeating_s = 3600.0;
constexpr int kLooks = 3;
constexpr double kSeenFor_s = 10.0;
// A unit's reading may be older than the air's by what the computer is behind: nothing at the pace of a real chamber,
// but many minutes of a simulated one.
constexpr std::chrono::seconds kBehindHost{2};

}  // namespace

bool ChamberGuard::Sighting::seen(bool now_seen, double now_s, HostTime host, HostTime::duration host_hold) {
  if (!now_seen) looks = 0;
  if (now_seen && ++looks == 1) {
    since_s = now_s;
    since = host;
  }
  return looks >= kLooks && now_s - since_s >= kSeenFor_s && host - since >= host_hold;
}

std::optional<std::string> ChamberGuard::look(double now_s, HostTime host, const hal::ChamberReading* reading,
                                              std::span<const GuardedUnit> units) {
  const bool at_set_point =
      reading != nullptr && reading->running && std::abs(reading->air_c - reading->set_point_c) <= kAtSetPoint_c;
  if (!at_set_point) at_set_point_since_s_.reset();
  if (at_set_point && !at_set_point_since_s_) at_set_point_since_s_ = now_s;
  if (reading == nullptr) standing_c_.reset();
  if (reading != nullptr) {
    if (auto trouble = judge_air(now_s, host, *reading)) return trouble;
    if (auto trouble = judge_heating(now_s, host, *reading)) return trouble;
  }
  for (const GuardedUnit& unit : units) {
    if (auto trouble = judge(unit, now_s, host, reading)) return trouble;
  }
  return std::nullopt;
}

std::optional<std::string> ChamberGuard::judge(const GuardedUnit& unit, double now_s, HostTime host,
                                               const hal::ChamberReading* reading) {
  Track& track = tracks_[unit.serial];
  track.temps.emplace_back(now_s, unit.temp_c);
  while (track.temps.size() > 2 && now_s - track.temps[1].first >= kFastWindow_s) track.temps.pop_front();

  const bool too_hot = unit.rated_max_c && unit.temp_c > *unit.rated_max_c + kRatingMargin_c;
  const bool too_cold = unit.rated_min_c && unit.temp_c < *unit.rated_min_c - kRatingMargin_c;
  if (track.outside.seen(too_hot || too_cold, now_s, host, {})) {
    return fmt::format("unit {} reads {:+.1f} °C, its type is rated {} {:+.0f} °C{}", unit.serial, unit.temp_c,
                       too_hot ? "up to" : "down to", too_hot ? *unit.rated_max_c : *unit.rated_min_c,
                       reading == nullptr ? "" : fmt::format("; the chamber says {:+.1f} °C", reading->air_c));
  }

  const auto& [then_s, then_c] = track.temps.front();
  const double elapsed_s = now_s - then_s;
  const double rate_kpmin = elapsed_s >= kFastWindow_s ? 60.0 * (unit.temp_c - then_c) / elapsed_s : 0.0;
  if (track.fast.seen(std::abs(rate_kpmin) > kFastest_kpmin, now_s, host, kBehindHost)) {
    return fmt::format("the temperature of unit {} moves by {:+.0f} K/min (now {:+.1f} °C)", unit.serial, rate_kpmin,
                       unit.temp_c);
  }

  const bool settled = at_set_point_since_s_ && now_s - *at_set_point_since_s_ >= kSettled_s;
  if (track.apart.seen(settled && std::abs(unit.temp_c - reading->air_c) > kApart_c, now_s, host, kBehindHost)) {
    return fmt::format(
        "unit {} reads {:+.1f} °C where the chamber says {:+.1f} °C: one of the two thermometers is wrong", unit.serial,
        unit.temp_c, reading->air_c);
  }
  return std::nullopt;
}

std::optional<std::string> ChamberGuard::judge_air(double now_s, HostTime host, const hal::ChamberReading& reading) {
  const double towards_c = reading.working_set_point_c.value_or(reading.set_point_c);
  const bool away = std::abs(reading.air_c - towards_c) > kAtSetPoint_c;
  // At the set point a settled chamber with a coarse thermometer stands as well: there only an output that has run away
  // tells that the controller does not see what it does.
  const double output_percent = std::abs(reading.output_percent.value_or(away ? 100.0 : 0.0));
  const bool driven = reading.running && output_percent >= (away ? kOutputOn_percent : kOutputRunAway_percent);
  if (!driven || standing_c_ != reading.air_c) {
    standing_c_ = driven ? std::optional(reading.air_c) : std::nullopt;
    standing_since_s_ = now_s;
    standing_since_ = host;
    return std::nullopt;
  }
  if (now_s - standing_since_s_ < kStanding_s || host - standing_since_ < kStandingHost) return std::nullopt;
  return fmt::format(
      "the chamber's temperature stands still at {:+.2f} °C although it is driven to {:+.1f} °C: its thermometer is "
      "stuck",
      reading.air_c, towards_c);
}

std::optional<std::string> ChamberGuard::judge_heating(double now_s, HostTime host,
                                                       const hal::ChamberReading& reading) {
  if (!at_set_point_since_s_ || reading.output_percent.value_or(0.0) < kFullHeating_percent) {
    full_heating_since_s_.reset();
    return std::nullopt;
  }
  if (!full_heating_since_s_) {
    full_heating_since_s_ = now_s;
    full_heating_since_ = host;
  }
  if (now_s - *full_heating_since_s_ < kFullHeating_s || host - full_heating_since_ < kStandingHost) {
    return std::nullopt;
  }
  return fmt::format(
      "the chamber has been heating all it can for an hour although its temperature is at its set point of {:+.1f} °C: "
      "its thermometer is not where the heat goes",
      reading.set_point_c);
}

}  // namespace soak::station
