// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/device_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "hal/devices/detail/registers.h"
#include "hal/maps/detail/action_reader.h"
#include "hal/maps/detail/axes_reader.h"
#include "hal/maps/detail/device_needs.h"
#include "hal/maps/detail/link_reader.h"
#include "hal/maps/detail/quantity_reader.h"
#include "hal/maps/detail/vocabulary.h"
#include "settings/reader.h"

namespace soak::hal {
namespace {

Vocabulary vocabulary_of(const RegisterMap& map) {
  if (map.kind == "fixture" && map.axes) return two_axis_vocabulary();
  if (map.kind == "fixture") return {{"request", "position", "status"}, {}};
  if (map.kind == "power") return {};  // its quantities are numbered
  return chamber_vocabulary();
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

std::optional<StepTarget> step_target(const RegisterMap& map, const std::string& name) {
  const auto found = map.quantities.find(name);
  if (found == map.quantities.end()) return std::nullopt;
  const Quantity& quantity = found->second;
  const auto fits = [quantity](double value) {
    // How many decimals a register has is known to the controller alone.
    return quantity.decimals_register || encode_value(quantity, value, 0);
  };
  return StepTarget{
      quantity.write_function.has_value(), "write_function", quantity.min, quantity.max, quantity.codes, fits};
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

/// A name that nothing asks for is most likely misspelt; a device reads what it asks for.
void check_names(const SettingsTable& quantities, const RegisterMap& map) {
  const Vocabulary known = vocabulary_of(map);
  const std::set<std::string> acted_on = written_by(map.actions);
  for (const auto& [name, quantity] : map.quantities) {
    const bool asked_for = known.quantities.contains(name) || asks_for(map.kind, name);
    if (asked_for && quantity.command) {
      quantities.refuse(name, fmt::format("'{}' is read as well: it cannot be a command", name));
    }
    if (asked_for || acted_on.contains(name)) continue;
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

/// One mistake that lists all that is lacking: it has no line of its own.
void refuse_incomplete(const SettingsTable& root, const RegisterMap& map) {
  const auto needs = device_needs(map);
  if (!needs.empty()) root.refuse("kind", fmt::format("{}", fmt::join(needs, "; ")));
}

RegisterMap read_map(const SettingsTable& root, MapUse use) {
  RegisterMap map;
  (void)root.choice<bool>("protocol", {{"modbus", true}}, true);
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
  if (map.kind == "fixture" && root.has("axes")) map.axes.emplace();
  map.actions = read_actions(root, map.kind, vocabulary_of(map).actions,
                             [&map](const std::string& quantity) { return step_target(map, quantity); });
  if (quantities && !map.kind.empty()) check_names(*quantities, map);
  map.alarms = read_alarms(root);
  map.write_policy = read_policy(root);
  if (map.axes) {
    read_axes(root, map);
  } else {
    map.positions = read_positions(root, map.kind);
    map.azimuths_deg = read_azimuths(root, map);
  }
  if (use == MapUse::device) refuse_incomplete(root, map);
  return map;
}

}  // namespace

base::Result<RegisterMap> parse_register_map(std::string_view text, const std::string& file, MapUse use) {
  const auto reader = SettingsReader::parse(text, file);
  if (!reader) return base::forward_error(reader);
  RegisterMap map = read_map(reader->root(), use);
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
