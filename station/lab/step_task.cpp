// SPDX-License-Identifier: Apache-2.0
#include "station/lab/step_task.h"

#include <fmt/format.h>

namespace soak::station {

std::unique_ptr<StepTask> make_task(const Plan& plan, std::size_t index) {
  const Step& step = plan.steps[index];
  switch (step.kind) {
    case StepKind::turn_fixture:
      return make_turn_fixture(step);
    case StepKind::power_on:
      return make_power_on(plan, step);
    case StepKind::move:
      return make_move(step);
    case StepKind::spin:
      return make_spin(step);
    case StepKind::set_temperature:
      return make_set_temperature(plan, step);
    case StepKind::wait_stable:
      return make_wait_stable(plan, step);
    case StepKind::record:
      return make_record(plan, step);
    case StepKind::check:
      return make_check();
    case StepKind::warm_end:
      return make_warm_end(step);
    case StepKind::power_off:
      return make_power_off(step);
  }
  return nullptr;
}

std::string attitudes_text(const std::vector<UnitChannel*>& units) {
  std::string text;
  for (const UnitChannel* unit : units) {
    text += fmt::format("{}unit {} in slot {} reads {} up where {} is expected", text.empty() ? "" : "; ",
                        unit->serial(), unit->slot().name, unit->attitude().seen(), unit->position().label);
  }
  return text;
}

std::vector<UnitChannel*> units_out_of_position(const Lab& lab) {
  std::vector<UnitChannel*> wrong = lab.active_units();
  std::erase_if(wrong, [](const UnitChannel* unit) { return unit->attitude().standing() == Standing::right; });
  return wrong;
}

}  // namespace soak::station
