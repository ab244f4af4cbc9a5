// SPDX-License-Identifier: Apache-2.0
#include "station/lab/safe_end.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

/// Between commands to a device that refuses them: their registers may lie in memory that wears out.
constexpr std::chrono::seconds kBetweenTries{1};

/// Power outputs of the campaign's units; of all slots where the units are not known.
std::vector<int> outputs_of(const Lab& lab) {
  std::vector<int> outputs;
  const auto add = [&](const Slot& slot) {
    if (slot.power_output) outputs.push_back(*slot.power_output);
  };
  for (const auto& unit : lab.units) add(unit->slot());
  if (lab.units.empty()) std::for_each(lab.config.slots.begin(), lab.config.slots.end(), add);
  return outputs;
}

/// One output that does not obey does not keep the others on.
base::Status switch_units_off(Lab& lab) {
  base::Status all;
  lab.supply->forget();
  for (const int output : outputs_of(lab)) {
    if (const auto off = lab.supply->switch_off(output, lab.now_s()); !off) all = off;
  }
  return all;
}

}  // namespace

SafeEnd::SafeEnd(std::string reason, double end_c, bool outputs_off)
    : reason_(std::move(reason)), outputs_off_(outputs_off), warmth_(end_c) {}

/// Tried for as long as the chamber takes; the chamber does not wait for it.
void SafeEnd::halt_fixture(Lab& lab) {
  if (steady_clock::now() < next_halt_) return;
  next_halt_ = steady_clock::now() + kBetweenTries;
  const auto halted = lab.halt_fixture();
  fixture_rests_ = halted.has_value();
  if (fixture_rests_ || fixture_is_blamed_) return;
  fixture_is_blamed_ = true;
  lab.log.add("device", "fixture", "cannot be halted: " + halted.error().message);
}

bool SafeEnd::make_chamber_safe(Lab& lab) { return outputs_off_ ? switch_chamber_off(lab) : warmth_.poll(lab); }

bool SafeEnd::switch_chamber_off(Lab& lab) {
  if (steady_clock::now() < next_stop_) return false;
  next_stop_ = steady_clock::now() + kBetweenTries;
  const auto off = lab.chamber.chamber().stop();
  if (!off && !chamber_is_blamed_) {
    chamber_is_blamed_ = true;
    lab.log.add("device", "chamber", "heating and cooling cannot be switched off: " + off.error().message);
  }
  return off.has_value();
}

bool SafeEnd::poll(Lab& lab) {
  // An alarm may come up on the way.
  if (const auto& reading = lab.chamber.reading()) {
    for (const hal::ChamberAlarm& alarm : reading->alarms) outputs_off_ = outputs_off_ || alarm.outputs_off;
  }
  if (!fixture_rests_) halt_fixture(lab);
  if (!chamber_is_safe_) chamber_is_safe_ = make_chamber_safe(lab);
  if (!chamber_is_safe_) return false;
  if (!run_is_sealed_) seal_run(lab);
  return units_are_off(lab);
}

void SafeEnd::seal_run(Lab& lab) {
  run_is_sealed_ = true;
  if (const auto sealed = lab.end_run(reason_); !sealed) {
    lab.log.add("run", lab.run_id(),
                "cannot be sealed now, the next start of a campaign or of soakd does it: " + sealed.error().message);
    lab.leave_run();
  }
}

/// A supply that has just been lost is asked again: its link may not even be tried before a pause is over.
bool SafeEnd::units_are_off(Lab& lab) {
  if (!lab.supply) return true;
  const auto off = units_off_.attempt([&] { return switch_units_off(lab); });
  if (off) return *off;
  lab.log.add("device", "power", "cannot be switched off: " + off.error().message);
  return true;
}

std::string SafeEnd::text(const Lab& lab) const {
  if (chamber_is_safe_) return "the chamber is off, the units are being switched off";
  if (!lab.chamber.reading()) {
    return fmt::format("the chamber does not answer ({}): go there, and switch it off by hand once the units are warm",
                       lab.chamber.trouble());
  }
  if (outputs_off_) {
    return chamber_is_blamed_ ? "heating and cooling cannot be switched off: go there and do it by hand"
                              : "switching heating and cooling off";
  }
  if (!warmth_.trouble().empty()) {
    return fmt::format("the chamber does not go to {:+.0f} °C ({}), heating and cooling are {}: go there",
                       warmth_.target_c(lab), warmth_.trouble(), lab.chamber.reading()->running ? "on" : "off");
  }
  return fmt::format("driving to {:+.0f} °C, so that no unit gathers dew", warmth_.target_c(lab));
}

}  // namespace soak::station
