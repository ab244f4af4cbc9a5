// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/action_reader.h"

#include <fmt/format.h>

#include <string_view>

namespace soak::hal {
namespace {

constexpr Limits kAnyNumber{-1e9, 1e9};
/// A call that carries an action out waits that long.
constexpr double kLongestDelay_s = 10.0;

double step_value(const SettingsTable& step, const std::optional<StepTarget>& target) {
  if (step.has("code") == step.has("value")) step.refuse("", "a step needs either 'code' or 'value'");
  if (!step.has("code")) return step.number("value", kAnyNumber, 0.0);
  const std::string code = step.text("code");
  if (!target) return 0.0;
  const auto found = target->codes.find(code);
  if (found != target->codes.end()) return found->second;
  step.refuse("code", fmt::format("the quantity has no code '{}'", code));
  return 0.0;
}

void check_step(const SettingsTable& table, const ActionStep& step, const StepTarget& target) {
  const std::string_view key = table.has("code") ? "code" : "value";
  if (!target.writable) {
    table.refuse("quantity", fmt::format("'{}' has no '{}'", step.quantity, target.needs));
  } else if (step.value < target.min.value_or(step.value) || step.value > target.max.value_or(step.value)) {
    table.refuse(key, fmt::format("{} is beyond the limits of '{}'", step.value, step.quantity));
  } else if (!target.fits(step.value)) {
    table.refuse(key, fmt::format("{} does not fit the register of '{}'", step.value, step.quantity));
  }
}

ActionStep read_step(const SettingsTable& table, const FindTarget& find) {
  ActionStep step;
  step.quantity = table.text("quantity");
  const auto target = find(step.quantity);
  step.value = step_value(table, target);
  step.delay_s = table.number("delay_s", {0.0, kLongestDelay_s}, 0.0);
  if (target) {
    check_step(table, step, *target);
  } else {
    table.refuse("quantity", fmt::format("there is no quantity '{}'", step.quantity));
  }
  return step;
}

}  // namespace

Actions read_actions(const SettingsTable& root, const std::string& kind, const std::set<std::string>& known,
                     const FindTarget& find) {
  Actions actions;
  const auto table = root.table("action");
  if (!table) return actions;
  for (const std::string& name : table->keys()) {
    std::vector<ActionStep>& steps = actions[name];
    double delays_s = 0.0;
    for (const SettingsTable& step : table->tables(name)) {
      steps.push_back(read_step(step, find));
      delays_s += steps.back().delay_s;
    }
    if (steps.empty()) table->refuse(name, fmt::format("action '{}' has no step", name));
    if (delays_s > kLongestDelay_s) {
      table->refuse(name, fmt::format("the delays of '{}' are more than {} s together", name, kLongestDelay_s));
    }
    if (!kind.empty() && !known.contains(name)) {
      table->refuse(name, fmt::format("a device of kind \"{}\" has no action '{}'", kind, name));
    }
  }
  return actions;
}

std::set<std::string> written_by(const Actions& actions) {
  std::set<std::string> quantities;
  for (const auto& [name, steps] : actions) {
    for (const ActionStep& step : steps) quantities.insert(step.quantity);
  }
  return quantities;
}

}  // namespace soak::hal
