// SPDX-License-Identifier: Apache-2.0
#include "station/lab/dew_safe_warm_up.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace soak::station {
namespace {

constexpr double kLowestEnd_c = 25.0;
constexpr double kDewMargin_c = 2.0;
constexpr double kEndReached_c = 1.0;
constexpr double kEndTolerance_c = 0.5;
constexpr double kSilentUnit_s = 1800.0;  ///< process time in warm air for a unit that does not send its temperature

/// Between commands to a device that refuses them: their registers may lie in memory that wears out.
constexpr std::chrono::seconds kWarmUpInterval{1};
constexpr int kWarmUpTries = 5;
constexpr double kSlowest_kpmin = 0.5;
constexpr double kWarmUpReserve_s = 7200.0;
constexpr double kNight_s = 28800.0;  ///< process time in which a room warms any chamber that is off

bool chamber_answers(const Station& station) { return station.chamber.reading() && station.chamber.trouble().empty(); }

}  // namespace

double safe_temp_c(double wanted_c, double dew_point_c) {
  return std::max({wanted_c, kLowestEnd_c, dew_point_c + 2.0 * kDewMargin_c});
}

DewSafeWarmUp::DewSafeWarmUp(double temp_c, const WarmUpPatience& patience) : temp_c_(temp_c), patience_(patience) {}

double DewSafeWarmUp::target_c(const Station& station) const {
  return safe_temp_c(temp_c_, station.config.dew_point_c);
}

bool DewSafeWarmUp::poll(Station& station) {
  watch(station);
  if (gave_up_) return is_off_ && room_has_warmed(station);
  // The units were dry and the chamber was to go off: it is not driven again, whatever it says of its set point.
  if (leaving_) return is_off_ || switch_off(station);
  if (!commanded_) {
    commanded_ = command(station);
    // It takes neither set point nor command: the one that makes it harmless is not left to the next try in a minute.
    if (!commanded_ && refusals_ > 0 && off_.is_refused()) (void)switch_off(station);
    return !commanded_ && is_off_ && room_has_warmed(station);
  }
  if (!obeys(station)) return false;
  if (std::abs(station.chamber.reading()->air_c - target_c(station)) > kEndReached_c) {
    warm_since_s_.reset();
    return false;
  }
  if (!warm_since_s_) warm_since_s_ = station.now_s();
  leaving_ = units_are_dry(station);
  return leaving_ && switch_off(station);
}

void DewSafeWarmUp::watch(Station& station) {
  const auto now = Clock::now();
  const auto& reading = station.chamber.reading();
  if (!read_ || reading) read_ = now;
  if (reading && !begun_) {
    begun_ = now;
    begun_s_ = station.now_s();
    limit_s_ = kWarmUpReserve_s + 60.0 * std::abs(reading->air_c - target_c(station)) / kSlowest_kpmin;
  }
  if (gave_up_ && is_off_) return;
  if (gave_up_ || overdue(station)) {
    gave_up_ = true;
    return give_up(station,
                   fmt::format("it has not come to {:+.0f} °C in {:.1f} h", target_c(station), limit_s_ / 3600.0));
  }
  if (!is_off_ && now - *read_ > patience_.unreadable) give_up(station, station.chamber.trouble());
}

/// By both clocks: with a fast simulated one process time alone would give a slow host no chance.
bool DewSafeWarmUp::overdue(const Station& station) {
  return begun_ && !warm_since_s_ && !is_off_ && station.now_s() - begun_s_ > limit_s_ &&
         Clock::now() - *begun_ > patience_.unreadable;
}

void DewSafeWarmUp::give_up(Station& station, const std::string& why) {
  trouble_ = why;
  if (!switch_off(station)) return;
  commanded_ = false;
  warm_since_s_.reset();
  next_command_ = Clock::now() + patience_.pause;
  station.log.add("device", "chamber", why + ": heating and cooling are switched off");
}

bool DewSafeWarmUp::command(Station& station) {
  const auto now = Clock::now();
  if (now < next_command_) return false;
  const bool answers = chamber_answers(station);
  if (is_off_ && !answers) return false;  // what nobody can read is not switched on again
  if (answers) ++commands_;
  next_command_ = now + (answers && commands_ >= kWarmUpTries ? patience_.pause : kWarmUpInterval);
  hal::Chamber& chamber = station.chamber.chamber();
  // A ramp that cannot be switched off makes the way longer, not impossible.
  if (chamber.can_ramp()) (void)chamber.set_ramp_rate(std::nullopt);
  const auto sent = chamber.set_temperature(target_c(station)).and_then([&] { return chamber.start(); });
  if (sent) {
    is_off_ = false;
    off_.forget();
    commanded_at_ = Clock::now();
    return true;
  }
  if (answers) handle_refusal(station, sent.error().message);
  return false;
}

void DewSafeWarmUp::handle_refusal(Station& station, const std::string& why) {
  trouble_ = why;
  ++refusals_;
  if (commands_ < kWarmUpTries || is_off_ || off_.is_refused()) return;
  (void)switch_off(station);
  station.log.add("device", "chamber",
                  fmt::format("cannot be driven to {:+.0f} °C ({}): heating and cooling {}", target_c(station), why,
                              is_off_ ? "are switched off" : "cannot be switched off either"));
}

/// Whether the chamber reports the set point that it was given. One that lost it (it restarted, someone pressed its
/// keys) is commanded again.
bool DewSafeWarmUp::obeys(const Station& station) {
  const auto& reading = station.chamber.reading();
  if (!reading || station.chamber.heard() < commanded_at_) return false;  // what it said before
  commanded_ = reading->running && std::abs(reading->set_point_c - target_c(station)) <= kEndTolerance_c;
  trouble_ = commanded_ ? ""
                        : fmt::format("its set point is {:+.1f} °C, heating and cooling {}", reading->set_point_c,
                                      reading->running ? "on" : "off");
  refusals_ = commanded_ ? 0 : refusals_ + 1;
  if (commanded_) off_.forget();  // it was to go off because nobody could read it
  return commanded_;
}

bool DewSafeWarmUp::is_refused() const { return gave_up_ || refusals_ >= kWarmUpTries; }

/// Whether the room has warmed what the chamber did not: it is off.
bool DewSafeWarmUp::room_has_warmed(const Station& station) {
  const auto& reading = station.chamber.reading();
  if (reading && reading->running) {
    warm_since_s_.reset();
    is_off_ = false;
    return false;
  }
  if (!reading || reading->air_c <= station.config.dew_point_c + kDewMargin_c) {
    warm_since_s_.reset();
    // Where its thermometer cannot be believed, a night is enough for any room.
    return (!reading || gave_up_) && station.now_s() - off_since_s_ >= kNight_s;
  }
  if (!warm_since_s_) warm_since_s_ = station.now_s();
  return units_are_dry(station);
}

bool DewSafeWarmUp::switch_off(Station& station) {
  is_off_ = off_.attempt(station);
  if (is_off_) off_since_s_ = station.now_s();
  return is_off_;
}

bool DewSafeWarmUp::units_are_dry(const Station& station) const {
  const double dry_c = station.config.dew_point_c + kDewMargin_c;
  const bool rested = station.now_s() - *warm_since_s_ >= kSilentUnit_s;
  if (station.units.empty()) return rested;
  return std::all_of(station.units.begin(), station.units.end(), [&](const auto& unit) {
    return unit->streaming() && unit->temp_c() ? *unit->temp_c() > dry_c : rested;
  });
}

}  // namespace soak::station
