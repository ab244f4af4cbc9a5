// SPDX-License-Identifier: Apache-2.0
#include "station/lab/safe_end.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace soak::station {
namespace {

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

}  // namespace

SafeEnd::SafeEnd(std::string reason, double end_c, bool outputs_off)
    : reason_(std::move(reason)), outputs_off_(outputs_off), warmth_(end_c) {}

/// Tried for as long as the chamber takes; the chamber does not wait for it.
void SafeEnd::halt_fixture(Lab& lab) {
  const auto halted = lab.halt_fixture();
  fixture_rests_ = halted.has_value();
  if (fixture_rests_ || fixture_is_blamed_) return;
  fixture_is_blamed_ = true;
  lab.log.add("device", "fixture", "cannot be halted: " + halted.error().message);
}

bool SafeEnd::make_chamber_safe(Lab& lab) {
  if (outputs_off_) return lab.chamber.chamber().stop().has_value();
  return warmth_.poll(lab);
}

bool SafeEnd::poll(Lab& lab) {
  // An alarm may come up on the way.
  if (const auto& reading = lab.chamber.reading()) {
    for (const hal::ChamberAlarm& alarm : reading->alarms) outputs_off_ = outputs_off_ || alarm.outputs_off;
  }
  if (!fixture_rests_) halt_fixture(lab);
  if (!chamber_is_safe_) chamber_is_safe_ = make_chamber_safe(lab);
  if (!chamber_is_safe_) return false;
  if (const auto sealed = lab.end_run(reason_); !sealed) {
    lab.log.add("run", lab.run_id(),
                "cannot be sealed now, the next start of a campaign or of soakd does it: " + sealed.error().message);
    lab.leave_run();
  }
  switch_units_off(lab);
  return true;
}

void SafeEnd::switch_units_off(Lab& lab) {
  if (!lab.supply) return;
  lab.supply->forget();
  for (const int output : outputs_of(lab)) {
    if (const auto off = lab.supply->switch_off(output, lab.now_s()); !off) {
      lab.log.add("device", "power", "cannot be switched off: " + off.error().message);
    }
  }
}

std::string SafeEnd::text(const Lab& lab) const {
  if (chamber_is_safe_) return "the chamber is off";
  if (!lab.chamber.reading()) {
    return fmt::format("the chamber does not answer ({}): go there, and switch it off by hand once the units are warm",
                       lab.chamber.trouble());
  }
  return outputs_off_ ? "switching heating and cooling off"
                      : fmt::format("driving to {:+.0f} °C, so that no unit gathers dew", warmth_.target_c(lab));
}

}  // namespace soak::station
