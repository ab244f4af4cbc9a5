// SPDX-License-Identifier: Apache-2.0
#include "hal/register_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "hal/modbus/link_reader.h"
#include "hal/modbus/quantity_reader.h"
#include "hal/modbus/registers.h"
#include "hal/settings_reader.h"

namespace soak::hal {
namespace {

/// A call that carries an action out waits that long.
constexpr double kLongestDelay_s = 10.0;

/// What a device of a kind asks its map for.
struct Vocabulary {
  std::set<std::string> quantities;
  std::set<std::string> actions;
};

bool is_output(std::string_view name) {
  for (const std::string_view prefix : {"output_", "state_"}) {
    if (!name.starts_with(prefix)) continue;
    const std::string_view number = name.substr(prefix.size());
    return !number.empty() && number.front() != '0' && number.find_first_not_of("0123456789") == number.npos;
  }
  return false;
}

Vocabulary vocabulary_of(const std::string& kind) {
  if (kind == "fixture") return {{"request", "position", "status"}, {}};
  if (kind == "power") return {};  // its quantities are numbered
  return {{"air_c", "set_point_c", "working_set_point_c", "output_percent", "control_mode", "actual_mode", "ramp_rate",
           "min_set_point_c", "max_set_point_c"},
          {"start", "stop", "ramp_on", "ramp_off"}};
}

Probe read_probe(const SettingsTable& table) {
  Probe probe;
  probe.name = table.text("name");
  probe.address = table.whole("address", kAddress);
  probe.type =
      table.choice<RegisterType>("type", {{"u16", RegisterType::u16}, {"i16", RegisterType::i16}}, RegisterType::u16);
  probe.expected = table.wholes("expected", content_limits(probe.type), true);
  if (table.has("expected") && probe.expected.empty()) table.refuse("expected", "'expected' names no number");
  probe.otherwise = table.text("otherwise");
  if (table.has("link")) probe.link = table.choice<LinkKind>("link", {{"tcp", LinkKind::tcp}, {"rtu", LinkKind::rtu}});
  return probe;
}

/// `quantity` is null if there is none of the step's name.
double step_value(const SettingsTable& step, const Quantity* quantity) {
  if (step.has("code") == step.has("value")) step.refuse("", "a step needs either 'code' or 'value'");
  if (!step.has("code")) return step.number("value", kAnyNumber, 0.0);
  const std::string code = step.text("code");
  if (!quantity) return 0.0;
  const auto found = quantity->codes.find(code);
  if (found != quantity->codes.end()) return found->second;
  step.refuse("code", fmt::format("the quantity has no code '{}'", code));
  return 0.0;
}

void check_step(const SettingsTable& table, const ActionStep& step, const Quantity& quantity) {
  const std::string_view key = table.has("code") ? "code" : "value";
  // How many decimals a register has is known to the controller alone.
  const bool fits = quantity.decimals_register || encode_value(quantity, step.value, 0);
  if (!quantity.write_function) {
    table.refuse("quantity", fmt::format("'{}' has no 'write_function'", step.quantity));
  } else if (step.value < quantity.min.value_or(step.value) || step.value > quantity.max.value_or(step.value)) {
    table.refuse(key, fmt::format("{} is beyond the limits of '{}'", step.value, step.quantity));
  } else if (!fits) {
    table.refuse(key, fmt::format("{} does not fit the register of '{}'", step.value, step.quantity));
  }
}

ActionStep read_step(const SettingsTable& table, const std::map<std::string, Quantity>& quantities) {
  ActionStep step;
  step.quantity = table.text("quantity");
  const auto found = quantities.find(step.quantity);
  const Quantity* quantity = found == quantities.end() ? nullptr : &found->second;
  step.value = step_value(table, quantity);
  step.delay_s = table.number("delay_s", {0.0, kLongestDelay_s}, 0.0);
  if (quantity) {
    check_step(table, step, *quantity);
  } else {
    table.refuse("quantity", fmt::format("there is no quantity '{}'", step.quantity));
  }
  return step;
}

AlarmRule read_alarm(const SettingsTable& table) {
  const Limits content = content_limits(RegisterType::u16);
  AlarmRule rule;
  rule.name = table.text("name");
  rule.addresses = table.wholes("addresses", kAddress, true);
  if (table.has("addresses") && rule.addresses.empty()) table.refuse("addresses", "'addresses' names no register");
  rule.inactive = table.wholes("inactive", content);
  rule.active = table.wholes("active", content);
  rule.mask = table.optional_whole("mask", {1, 65535});
  if (int{table.has("inactive")} + int{table.has("active")} + int{table.has("mask")} != 1) {
    table.refuse("", "an alarm needs one of 'inactive', 'active' and 'mask'");
  } else if (!table.has("mask") && rule.inactive.empty() && rule.active.empty()) {
    table.refuse(table.has("active") ? "active" : "inactive", "the list names no number");
  }
  rule.outputs_off = table.flag("outputs_off", false);
  return rule;
}

std::vector<AlarmRule> read_alarms(const SettingsTable& root) {
  std::vector<AlarmRule> rules;
  std::set<std::string> names;
  for (const SettingsTable& alarm : root.tables("alarm")) {
    rules.push_back(read_alarm(alarm));
    if (names.insert(rules.back().name).second) continue;
    alarm.refuse("name", fmt::format("alarm '{}' occurs twice", rules.back().name));
  }
  return rules;
}

std::vector<std::string> read_positions(const SettingsTable& root, const std::string& kind) {
  const bool fixture = kind == "fixture";
  std::vector<std::string> labels = root.texts("positions", fixture);
  if (!fixture && root.has("positions")) root.refuse("positions", "'positions' belongs to kind \"fixture\"");
  if (root.has("positions") && labels.empty()) root.refuse("positions", "'positions' names no position");
  std::vector<std::string> sorted = labels;
  std::sort(sorted.begin(), sorted.end());
  const auto twin = std::adjacent_find(sorted.begin(), sorted.end());
  if (twin != sorted.end()) root.refuse("positions", fmt::format("position '{}' occurs twice", *twin));
  return labels;
}

std::vector<double> read_azimuths(const SettingsTable& root, const RegisterMap& map) {
  std::vector<double> azimuths = root.numbers("azimuths_deg", {-360.0, 360.0});
  if (root.has("azimuths_deg") && azimuths.size() != map.positions.size()) {
    root.refuse("azimuths_deg", "'azimuths_deg' must have one number for each of 'positions'");
  }
  return azimuths;
}

void read_actions(const SettingsTable& root, RegisterMap& map) {
  const auto actions = root.table("action");
  if (!actions) return;
  const Vocabulary known = vocabulary_of(map.kind);
  for (const std::string& name : actions->keys()) {
    std::vector<ActionStep>& steps = map.actions[name];
    double delays_s = 0.0;
    for (const SettingsTable& step : actions->tables(name)) {
      steps.push_back(read_step(step, map.quantities));
      delays_s += steps.back().delay_s;
    }
    if (steps.empty()) actions->refuse(name, fmt::format("action '{}' has no step", name));
    if (delays_s > kLongestDelay_s) {
      actions->refuse(name, fmt::format("the delays of '{}' are more than {} s together", name, kLongestDelay_s));
    }
    if (!map.kind.empty() && !known.actions.contains(name)) {
      actions->refuse(name, fmt::format("a device of kind \"{}\" has no action '{}'", map.kind, name));
    }
  }
}

/// A name that nothing asks for is most likely misspelt.
void refuse_unused(const SettingsTable& quantities, const RegisterMap& map) {
  Vocabulary known = vocabulary_of(map.kind);
  for (const auto& [name, steps] : map.actions) {
    for (const ActionStep& step : steps) known.quantities.insert(step.quantity);
  }
  for (const auto& [name, quantity] : map.quantities) {
    if (known.quantities.contains(name) || (map.kind == "power" && is_output(name))) continue;
    quantities.refuse(name, fmt::format("a device of kind \"{}\" does not use the quantity '{}', nor does an action",
                                        map.kind, name));
  }
}

WritePolicy read_policy(const SettingsTable& root) {
  WritePolicy policy;
  if (const auto table = root.table("write_policy")) {
    policy.only_on_change = table->flag("only_on_change", policy.only_on_change);
    policy.read_back = table->flag("read_back", policy.read_back);
  }
  return policy;
}

RegisterMap read_map(const SettingsTable& root) {
  RegisterMap map;
  map.name = root.text("name");
  map.kind = root.choice<std::string>("kind", {{"chamber", "chamber"}, {"fixture", "fixture"}, {"power", "power"}});
  if (const auto link = root.table("link", true)) map.link = read_link(*link);
  const auto quantities = root.table("quantity", true);
  if (quantities) {
    for (const std::string& name : quantities->keys()) {
      if (const auto table = quantities->table(name)) map.quantities[name] = read_quantity(*table);
    }
  }
  for (const SettingsTable& probe : root.tables("probe")) map.probes.push_back(read_probe(probe));
  read_actions(root, map);
  if (quantities && !map.kind.empty()) refuse_unused(*quantities, map);
  map.alarms = read_alarms(root);
  map.write_policy = read_policy(root);
  map.positions = read_positions(root, map.kind);
  map.azimuths_deg = read_azimuths(root, map);
  return map;
}

}  // namespace

base::Result<RegisterMap> parse_register_map(std::string_view text, const std::string& file) {
  const auto reader = SettingsReader::parse(text, file);
  if (!reader) return base::forward_error(reader);
  RegisterMap map = read_map(reader->root());
  if (auto status = reader->finish(); !status) return base::forward_error(status);
  map.file = file;
  return map;
}

base::Result<RegisterMap> read_register_map(const std::string& file) {
  const auto text = read_settings_text(file);
  if (!text) return base::forward_error(text);
  return parse_register_map(*text, file);
}

}  // namespace soak::hal
