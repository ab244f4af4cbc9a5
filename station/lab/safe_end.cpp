// SPDX-License-Identifier: Apache-2.0
#include "station/lab/safe_end.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

/// Between tries.
constexpr std::chrono::seconds kSafeEndInterval{1};
/// A chamber that has not done for so long what it was told will not: process time, as the way to the safe state may
/// take beyond its own length, and host time.
constexpr double kHopeless_s = 7200.0;
constexpr std::chrono::seconds kHopeless{60};
/// Looks at the units' outputs that one may take after they were switched off, a second from one to the next.
constexpr int kMostLooks = 5;

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

/// Those that are on although they were switched off.
base::Result<std::vector<int>> outputs_on(Station& station) {
  const std::vector<int> outputs = outputs_of(station);
  if (auto read = station.supply->read(outputs, station.now_s()); !read) return base::forward_error(read);
  std::vector<int> on;
  std::ranges::copy_if(outputs, std::back_inserter(on), [&](int output) { return station.supply->is_on(output); });
  return on;
}

}  // namespace

SafeEnd::SafeEnd(std::string reason, double end_c, bool outputs_off, bool aborted)
    : reason_(std::move(reason)), outputs_off_(outputs_off), aborted_(aborted), warm_up_(end_c) {}

bool SafeEnd::poll(Station& station) {
  if (!obeyed_ || (!station.chamber.stale() && !warm_up_.off().is_refused())) {
    obeyed_ = steady_clock::now();
    obeyed_s_ = station.now_s();
  }
  // An alarm may come up on the way.
  for (const hal::ChamberAlarm& alarm : station.chamber.alarms()) {
    if (trouble_.empty()) trouble_ = "the chamber reports an alarm: " + alarm.name;
    outputs_off_ = outputs_off_ || alarm.outputs_off;
  }
  if (!chamber_is_safe_) chamber_is_safe_ = outputs_off_ ? warm_up_.switch_off(station) : warm_up_.poll(station);
  if (!fixture_is_halted_) halt_fixture(station);
  // Units are not left on in a chamber that was to go off at once and does not.
  if (!chamber_is_safe_ && !(outputs_off_ && warm_up_.off().is_alarm())) return false;
  if (!run_is_sealed_) seal_run(station);
  if (!units_are_off_) units_are_off_ = units_are_off(station);
  return chamber_is_safe_ && run_is_sealed_ && units_are_off_;
}

std::string SafeEnd::why_hopeless(const Station& station) const {
  const bool is_over = !chamber_is_safe_ && obeyed_ && station.now_s() - obeyed_s_ > kHopeless_s &&
                       steady_clock::now() - *obeyed_ > kHopeless;
  if (!is_over) return {};
  return fmt::format("for two hours it has not answered, or not gone off ({})",
                     station.chamber.stale() ? station.chamber.trouble() : warm_up_.off().trouble());
}

std::string SafeEnd::leave_units(Station& station) {
  if (!station.supply || units_are_off_) return {};
  if (const auto off = switch_units_off(station); !off)
    return "the units cannot be switched off: " + off.error().message;
  return {};
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
  if (!trouble_.empty()) return trouble_;
  if (warm_up_.off().is_alarm()) return "the chamber cannot be switched off: " + warm_up_.off().trouble();
  return warm_up_.is_refused() ? "the chamber refuses: " + warm_up_.trouble() : "";
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
  if (looks_ > 0) return units_stay_off(station);
  const auto off = units_off_.attempt([&] { return switch_units_off(station); });
  if (!off) {
    station.log.add("alarm", "power",
                    "cannot be switched off (" + off.error().message + "): go there and see that the units are off");
    return true;
  }
  if (!*off) return false;
  looks_ = outputs_of(station).empty() ? 0 : kMostLooks;
  next_look_ = steady_clock::now() + kSafeEndInterval;
  return looks_ == 0;
}

/// A command of a soakd that was killed may still have been on its way to the supply, and have come behind ours.
bool SafeEnd::units_stay_off(Station& station) {
  if (steady_clock::now() < next_look_) return false;
  next_look_ = steady_clock::now() + kSafeEndInterval;
  const auto on = outputs_on(station);
  if (on && on->empty()) return true;
  --looks_;
  const std::string found =
      on ? fmt::format("outputs {} were on after they had been switched off", fmt::join(*on, ", "))
         : "cannot be read after it was switched off: " + on.error().message;
  const std::string then = looks_ > 0 ? "they are switched off again" : "go there and see that the units are off";
  if (on || looks_ == 0) station.log.add(looks_ > 0 ? "power" : "alarm", "power", found + ": " + then);
  if (on) (void)switch_units_off(station);
  return looks_ == 0;
}

bool SafeEnd::needs_somebody(const Station& station) const {
  if (chamber_is_safe_) return false;
  if (station.chamber.stale()) return true;
  return warm_up_.off().is_refused() || (!outputs_off_ && warm_up_.is_refused());
}

std::string SafeEnd::text(const Station& station) const {
  const auto& reading = station.chamber.reading();
  if (chamber_is_safe_) return "the chamber is off, the run is being sealed, the units are being switched off";
  if (!reading) {
    return fmt::format(
        "the chamber does not answer ({}): go to the chamber, and switch it off by hand once the units are warm",
        station.chamber.trouble());
  }
  if (warm_up_.off().is_refused()) {
    return fmt::format("heating and cooling cannot be switched off ({}): go to the chamber and switch them off by hand",
                       warm_up_.off().trouble());
  }
  if (outputs_off_) return "switching heating and cooling off";
  const double target = warm_up_.target_c(station);
  if (!warm_up_.trouble().empty()) {
    return fmt::format("the chamber does not drive to {:+.0f} °C ({}); heating and cooling are {}: go to the chamber",
                       target, warm_up_.trouble(), reading->running ? "on" : "off");
  }
  return fmt::format("driving the chamber to {:+.0f} °C, so that no dew forms on the units", target);
}

}  // namespace soak::station
