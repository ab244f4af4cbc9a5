// SPDX-License-Identifier: Apache-2.0
#include "station/lab/safe_end.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr double kLowestEnd_c = 25.0;
constexpr double kDewMargin_c = 2.0;
constexpr double kEndReached_c = 1.0;
constexpr double kEndTolerance_c = 0.5;
constexpr double kSilentUnit_s = 1800.0;  ///< process time in warm air for a unit that does not send its temperature

/// Between commands to a device that refuses them: their registers may lie in memory that wears out.
constexpr std::chrono::seconds kSafeEndInterval{1};
constexpr int kWarmUpTries = 5;
constexpr std::chrono::seconds kLaterWarmUpInterval{60};
constexpr std::chrono::seconds kUnreadable{60};  ///< after which a chamber that nobody can read is switched off
constexpr double kSlowest_kpmin = 0.5;
constexpr double kWarmUpReserve_s = 7200.0;
constexpr double kNight_s = 28800.0;  ///< process time in which a room warms any chamber that is off

bool chamber_answers(const Station& station) { return station.chamber.reading() && station.chamber.trouble().empty(); }

/// Power outputs of the campaign's units; of all slots where the units are not known.
std::vector<int> outputs_of(const Station& station) {
  std::vector<int> outputs;
  const auto add = [&](const Slot& slot) {
    if (slot.power_output) outputs.push_back(*slot.power_output);
  };
  for (const auto& unit : station.units) add(unit->slot());
  if (station.units.empty()) std::for_each(station.config.slots.begin(), station.config.slots.end(), add);
  return outputs;
}

/// An output that cannot be switched does not keep the others on.
base::Status switch_units_off(Station& station) {
  base::Status all;
  station.supply->forget();
  for (const int output : outputs_of(station)) {
    if (const auto off = station.supply->switch_off(output, station.now_s()); !off) all = off;
  }
  return all;
}

}  // namespace

// --- DewSafeWarmUp ----------------------------------------------------------------------------------------------

double safe_temp_c(double wanted_c, double dew_point_c) {
  return std::max({wanted_c, kLowestEnd_c, dew_point_c + 2.0 * kDewMargin_c});
}

namespace {

/// Switches off and looks: a controller may take the command and go on. One that cannot be read has taken it.
base::Status switch_off_and_see(hal::Chamber& chamber) {
  if (auto off = chamber.stop(); !off) return off;
  const auto now = chamber.read();
  if (!now || !now->running) return {};
  return base::fail(base::ErrorKind::device, "it took the command, but still says that they are on",
                    chamber.description());
}

}  // namespace

DewSafeWarmUp::DewSafeWarmUp(double temp_c) : temp_c_(temp_c) {}

double DewSafeWarmUp::target_c(const Station& station) const {
  return safe_temp_c(temp_c_, station.config.dew_point_c);
}

bool DewSafeWarmUp::poll(Station& station) {
  watch(station);
  if (gave_up_) return is_off_ && room_has_warmed(station);
  if (!commanded_) {
    commanded_ = command(station);
    return !commanded_ && is_off_ && room_has_warmed(station);
  }
  if (!obeys(station)) return false;
  if (std::abs(station.chamber.reading()->air_c - target_c(station)) > kEndReached_c) {
    warm_since_s_.reset();
    return false;
  }
  if (!warm_since_s_) warm_since_s_ = station.now_s();
  return units_are_dry(station) && switch_off(station);
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
  if (!is_off_ && now - *read_ > kUnreadable) give_up(station, station.chamber.trouble());
}

/// By both clocks: with a fast simulated one process time alone would give a slow host no chance.
bool DewSafeWarmUp::overdue(const Station& station) {
  return begun_ && !warm_since_s_ && !is_off_ && station.now_s() - begun_s_ > limit_s_ &&
         Clock::now() - *begun_ > kUnreadable;
}

void DewSafeWarmUp::give_up(Station& station, const std::string& why) {
  trouble_ = why;
  if (Clock::now() < next_stop_) return;
  next_stop_ = Clock::now() + kSafeEndInterval;
  is_off_ = switch_off_and_see(station.chamber.chamber()).has_value();
  if (!is_off_) return;
  commanded_ = false;
  off_since_s_ = station.now_s();
  warm_since_s_.reset();
  next_command_ = Clock::now() + kLaterWarmUpInterval;
  station.log.add("device", "chamber", why + ": heating and cooling are switched off");
}

bool DewSafeWarmUp::command(Station& station) {
  const auto now = Clock::now();
  if (now < next_command_) return false;
  const bool answers = chamber_answers(station);
  if (is_off_ && !answers) return false;  // what nobody can read is not switched on again
  if (answers) ++commands_;
  next_command_ = now + (answers && commands_ >= kWarmUpTries ? kLaterWarmUpInterval : kSafeEndInterval);
  hal::Chamber& chamber = station.chamber.chamber();
  // A ramp that cannot be switched off makes the way longer, not impossible.
  if (chamber.can_ramp()) (void)chamber.set_ramp_rate(std::nullopt);
  const auto sent = chamber.set_temperature(target_c(station)).and_then([&] { return chamber.start(); });
  if (sent) {
    is_off_ = false;
    commanded_at_ = Clock::now();
    return true;
  }
  if (answers) handle_refusal(station, sent.error().message);
  return false;
}

void DewSafeWarmUp::handle_refusal(Station& station, const std::string& why) {
  trouble_ = why;
  ++refusals_;
  if (commands_ < kWarmUpTries || is_off_) return;
  is_off_ = switch_off_and_see(station.chamber.chamber()).has_value();
  off_since_s_ = station.now_s();
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
  const auto now = Clock::now();
  if (now < next_stop_) return false;
  next_stop_ = now + kSafeEndInterval;
  const auto stopped = switch_off_and_see(station.chamber.chamber());
  trouble_ = stopped ? "" : stopped.error().message;
  return stopped.has_value();
}

bool DewSafeWarmUp::units_are_dry(const Station& station) const {
  const double dry_c = station.config.dew_point_c + kDewMargin_c;
  const bool rested = station.now_s() - *warm_since_s_ >= kSilentUnit_s;
  if (station.units.empty()) return rested;
  return std::all_of(station.units.begin(), station.units.end(), [&](const auto& unit) {
    return unit->streaming() && unit->temp_c() ? *unit->temp_c() > dry_c : rested;
  });
}

// --- SafeEnd ----------------------------------------------------------------------------------------------------

SafeEnd::SafeEnd(std::string reason, double end_c, bool outputs_off, bool aborted)
    : reason_(std::move(reason)), outputs_off_(outputs_off), aborted_(aborted), warm_up_(end_c) {}

bool SafeEnd::poll(Station& station) {
  if (!heard_ || !station.chamber.stale()) {
    heard_ = steady_clock::now();
    heard_s_ = station.now_s();
  }
  // An alarm may come up on the way.
  for (const hal::ChamberAlarm& alarm : station.chamber.alarms()) {
    if (trouble_.empty()) trouble_ = "the chamber reports an alarm: " + alarm.name;
    outputs_off_ = outputs_off_ || alarm.outputs_off;
  }
  if (!chamber_is_safe_) chamber_is_safe_ = outputs_off_ ? switch_chamber_off(station) : warm_up_.poll(station);
  if (!fixture_is_halted_) halt_fixture(station);
  if (!chamber_is_safe_) return false;
  if (!run_is_sealed_) seal_run(station);
  if (!units_are_off_) units_are_off_ = units_are_off(station);
  return run_is_sealed_ && units_are_off_;
}

bool SafeEnd::is_silent_for_good(const Station& station) const {
  return !chamber_is_safe_ && heard_ && station.now_s() - heard_s_ > kWarmUpReserve_s &&
         steady_clock::now() - *heard_ > kUnreadable;
}

void SafeEnd::switch_off_at_once(Station& station, const std::string& why) {
  if (outputs_off_) return;
  outputs_off_ = true;
  trouble_ = why;
  station.log.add("alarm", "chamber", why + ": heating and cooling are switched off");
}

void SafeEnd::note_abort(const std::string& reason) {
  reason_ = reason;
  aborted_ = true;
}

std::string SafeEnd::trouble() const {
  return trouble_.empty() && warm_up_.is_refused() ? "the chamber refuses: " + warm_up_.trouble() : trouble_;
}

/// Tried for as long as the chamber takes; the chamber does not wait for it.
void SafeEnd::halt_fixture(Station& station) {
  if (steady_clock::now() < next_halt_) return;
  next_halt_ = steady_clock::now() + kSafeEndInterval;
  const auto halted = station.halt_fixture();
  fixture_is_halted_ = halted.has_value();
  if (fixture_is_halted_ || fixture_was_reported_) return;
  fixture_was_reported_ = true;
  station.log.add("device", "fixture", "cannot be halted: " + halted.error().message);
}

bool SafeEnd::switch_chamber_off(Station& station) {
  if (steady_clock::now() < next_stop_) return false;
  next_stop_ = steady_clock::now() + kSafeEndInterval;
  const auto off = switch_off_and_see(station.chamber.chamber());
  if (!off && !chamber_was_reported_) {
    chamber_was_reported_ = true;
    station.log.add("device", "chamber", "heating and cooling cannot be switched off: " + off.error().message);
  }
  return off.has_value();
}

void SafeEnd::seal_run(Station& station) {
  const auto sealed = station.end_run(reason_, aborted_);
  run_is_sealed_ = !sealed || *sealed;
  if (sealed) return;
  station.log.add(
      "run", station.run_id(),
      "cannot be sealed now; this is tried again when a campaign or soakd starts: " + sealed.error().message);
  station.leave_run();
}

/// A supply that has just been lost is asked again: its link may not even be tried before a pause is over.
bool SafeEnd::units_are_off(Station& station) {
  if (!station.supply) return true;
  const auto off = units_off_.attempt([&] { return switch_units_off(station); });
  if (off) return *off;
  station.log.add("device", "power", "cannot be switched off: " + off.error().message);
  return true;
}

bool SafeEnd::needs_somebody(const Station& station) const {
  if (chamber_is_safe_) return false;
  if (station.chamber.stale()) return true;
  return outputs_off_ ? chamber_was_reported_ : warm_up_.is_refused();
}

std::string SafeEnd::text(const Station& station) const {
  const auto& reading = station.chamber.reading();
  if (chamber_is_safe_) return "the chamber is off, the run is being sealed, the units are being switched off";
  if (!reading) {
    return fmt::format(
        "the chamber does not answer ({}): go to the chamber, and switch it off by hand once the units are warm",
        station.chamber.trouble());
  }
  if (outputs_off_) {
    return chamber_was_reported_
               ? "heating and cooling cannot be switched off: go to the chamber and switch them off by hand"
               : "switching heating and cooling off";
  }
  const double target = warm_up_.target_c(station);
  if (!warm_up_.trouble().empty()) {
    return fmt::format("the chamber does not drive to {:+.0f} °C ({}); heating and cooling are {}: go to the chamber",
                       target, warm_up_.trouble(), reading->running ? "on" : "off");
  }
  return fmt::format("driving the chamber to {:+.0f} °C, so that no dew forms on the units", target);
}

}  // namespace soak::station
