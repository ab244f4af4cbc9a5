// SPDX-License-Identifier: Apache-2.0
#include "hal/register_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "hal/settings_reader.h"

namespace soak::hal {
namespace {

constexpr Limits kAddress{0, 65535};
constexpr Limits kWord{-32768, 65535};
constexpr Limits kAnyNumber{-1e9, 1e9};

ModbusTcp read_tcp(const SettingsTable& link) {
  constexpr int last_port = 65535;
  const std::string text = link.text("tcp");
  const std::size_t colon = text.rfind(':');
  ModbusTcp address{.host = text.substr(0, colon)};
  if (colon != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto [stop, failure] = std::from_chars(text.data() + colon + 1, end, address.port);
    if (failure != std::errc{} || stop != end) address.port = 0;
  }
  if (address.host.empty() || address.port < 1 || address.port > last_port) {
    link.refuse("tcp", fmt::format("'link.tcp' must be \"host:port\", not \"{}\"", text));
  }
  return address;
}

ModbusRtu read_rtu(const SettingsTable& link) {
  constexpr int default_baud = 9600;
  // libmodbus takes any other for 9600.
  const std::vector<int> bauds = {1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200};
  ModbusRtu address;
  address.device = link.text("rtu");
  address.baud = link.whole("baud", kAnyNumber, default_baud);
  if (std::find(bauds.begin(), bauds.end(), address.baud) == bauds.end()) {
    link.refuse("baud", fmt::format("'link.baud' must be one of {}", fmt::join(bauds, ", ")));
  }
  address.parity = link.choice<char>("parity", {{"N", 'N'}, {"E", 'E'}, {"O", 'O'}}, 'N');
  address.stop_bits = link.whole("stop_bits", {1, 2}, 1);
  return address;
}

ModbusLinkSettings read_link(const SettingsTable& link) {
  constexpr Limits unit_limits{0, 255};
  constexpr int last_unit = 247;
  constexpr int direct_unit = 255;
  ModbusLinkSettings settings;
  const bool rtu = link.has("rtu");
  if (rtu == link.has("tcp")) link.refuse("", "'link' needs either 'tcp' or 'rtu'");
  if (rtu) settings.address = read_rtu(link);
  if (link.has("tcp")) settings.address = read_tcp(link);
  settings.unit = link.whole("unit", unit_limits, settings.unit);
  const bool reserved = settings.unit > last_unit && settings.unit != direct_unit;
  if (reserved || (rtu && (settings.unit == 0 || settings.unit == direct_unit))) {
    link.refuse("unit", fmt::format("'link.unit' must be from 1 to {}{}", last_unit, rtu ? "" : ", or 0 or 255"));
  }
  settings.response_timeout_s = link.number("response_timeout_s", {0.05, 30.0}, settings.response_timeout_s);
  settings.gap_s = link.number("gap_s", {0.0, 1.0}, settings.gap_s);
  settings.max_block = link.whole("max_block", {2, 125}, settings.max_block);
  settings.poll_s = link.number("poll_s", {0.1, 60.0}, settings.poll_s);
  return settings;
}

std::map<std::string, int> read_codes(const SettingsTable& quantity) {
  std::map<std::string, int> codes;
  const auto table = quantity.table("codes");
  if (!table) return codes;
  for (const std::string& name : table->keys()) codes[name] = table->whole(name, kWord);
  return codes;
}

void check_float(const SettingsTable& table, const Quantity& quantity) {
  if (quantity.address == static_cast<int>(kAddress.high)) {
    table.refuse("address", "a value of type f32 takes two registers");
  }
  if (quantity.write_function == 6) table.refuse("write_function", "a value of type f32 is written by function 16");
  if (quantity.decimals_register) table.refuse("decimals_register", "a value of type f32 has no 'decimals_register'");
}

void check_write_limits(const SettingsTable& table, const Quantity& quantity) {
  if (!quantity.write_function) {
    for (const char* key : {"min", "max"}) {
      if (table.has(key)) table.refuse(key, fmt::format("'{}' limits a write, but there is no 'write_function'", key));
    }
  }
  if (quantity.min && quantity.max && *quantity.min > *quantity.max) table.refuse("min", "'min' is above 'max'");
}

Quantity read_quantity(const SettingsTable& table) {
  Quantity quantity;
  quantity.address = table.whole("address", kAddress);
  quantity.type = table.choice<RegisterType>(
      "type", {{"u16", RegisterType::u16}, {"i16", RegisterType::i16}, {"f32", RegisterType::f32}});
  quantity.word_order = table.choice<WordOrder>(
      "word_order", {{"low_first", WordOrder::low_first}, {"high_first", WordOrder::high_first}}, WordOrder::low_first);
  if (quantity.type != RegisterType::f32 && table.has("word_order")) {
    table.refuse("word_order", "'word_order' belongs to type f32");
  }
  quantity.scale = table.number("scale", kAnyNumber, 1.0);
  if (quantity.scale == 0.0) table.refuse("scale", "'scale' must not be 0");
  quantity.decimals_register = table.optional_whole("decimals_register", kAddress);
  quantity.read_function = table.whole("read_function", {3, 4}, 3);
  quantity.write_function = table.optional_whole("write_function", {6, 16});
  if (quantity.write_function && *quantity.write_function != 6 && *quantity.write_function != 16) {
    table.refuse("write_function", "'write_function' must be 6 or 16");
  }
  quantity.min = table.optional_number("min", kAnyNumber);
  quantity.max = table.optional_number("max", kAnyNumber);
  quantity.codes = read_codes(table);
  if (quantity.type == RegisterType::f32) check_float(table, quantity);
  check_write_limits(table, quantity);
  return quantity;
}

Probe read_probe(const SettingsTable& table) {
  Probe probe;
  probe.name = table.text("name");
  probe.address = table.whole("address", kAddress);
  probe.type =
      table.choice<RegisterType>("type", {{"u16", RegisterType::u16}, {"i16", RegisterType::i16}}, RegisterType::u16);
  probe.expected = table.wholes("expected", kWord, true);
  if (table.has("expected") && probe.expected.empty()) table.refuse("expected", "'expected' names no number");
  probe.otherwise = table.text("otherwise");
  return probe;
}

double step_value(const SettingsTable& step, const Quantity& quantity) {
  if (!step.has("code")) return step.number("value", kAnyNumber);
  const std::string code = step.text("code");
  const auto found = quantity.codes.find(code);
  if (found != quantity.codes.end()) return found->second;
  step.refuse("code", fmt::format("the quantity has no code '{}'", code));
  return 0.0;
}

ActionStep read_step(const SettingsTable& table, const std::map<std::string, Quantity>& quantities) {
  ActionStep step;
  step.quantity = table.text("quantity");
  const auto found = quantities.find(step.quantity);
  static const Quantity unknown;
  const Quantity& quantity = found == quantities.end() ? unknown : found->second;
  if (table.has("code") == table.has("value")) table.refuse("", "a step needs either 'code' or 'value'");
  step.value = step_value(table, quantity);
  step.delay_s = table.number("delay_s", {0.0, 10.0}, 0.0);
  if (found == quantities.end()) {
    table.refuse("quantity", fmt::format("there is no quantity '{}'", step.quantity));
  } else if (!quantity.write_function) {
    table.refuse("quantity", fmt::format("'{}' has no 'write_function'", step.quantity));
  } else if (step.value < quantity.min.value_or(step.value) || step.value > quantity.max.value_or(step.value)) {
    table.refuse("value", fmt::format("{} is beyond the limits of '{}'", step.value, step.quantity));
  }
  return step;
}

AlarmRule read_alarm(const SettingsTable& table) {
  AlarmRule rule;
  rule.name = table.text("name");
  rule.addresses = table.wholes("addresses", kAddress, true);
  if (table.has("addresses") && rule.addresses.empty()) table.refuse("addresses", "'addresses' names no register");
  rule.inactive = table.wholes("inactive", kWord);
  rule.active = table.wholes("active", kWord);
  rule.mask = table.optional_whole("mask", {1, 65535});
  if (int{table.has("inactive")} + int{table.has("active")} + int{table.has("mask")} != 1) {
    table.refuse("", "an alarm needs one of 'inactive', 'active' and 'mask'");
  }
  rule.outputs_off = table.flag("outputs_off", false);
  return rule;
}

std::vector<std::string> read_positions(const SettingsTable& root, const std::string& kind) {
  const bool fixture = kind == "fixture";
  std::vector<std::string> labels = root.texts("positions", fixture);
  if (!fixture && root.has("positions")) root.refuse("positions", "'positions' belongs to kind \"fixture\"");
  std::vector<std::string> sorted = labels;
  std::sort(sorted.begin(), sorted.end());
  const auto twin = std::adjacent_find(sorted.begin(), sorted.end());
  if (twin != sorted.end()) root.refuse("positions", fmt::format("position '{}' occurs twice", *twin));
  return labels;
}

void read_actions(const SettingsTable& root, RegisterMap& map) {
  const auto actions = root.table("action");
  if (!actions) return;
  for (const std::string& name : actions->keys()) {
    std::vector<ActionStep>& steps = map.actions[name];
    for (const SettingsTable& step : actions->tables(name)) steps.push_back(read_step(step, map.quantities));
  }
}

RegisterMap read_map(const SettingsTable& root) {
  RegisterMap map;
  map.name = root.text("name");
  map.kind = root.choice<std::string>("kind", {{"chamber", "chamber"}, {"fixture", "fixture"}, {"power", "power"}});
  if (const auto link = root.table("link", true)) map.link = read_link(*link);
  if (const auto quantities = root.table("quantity", true)) {
    for (const std::string& name : quantities->keys()) {
      if (const auto table = quantities->table(name)) map.quantities[name] = read_quantity(*table);
    }
  }
  for (const SettingsTable& probe : root.tables("probe")) map.probes.push_back(read_probe(probe));
  read_actions(root, map);
  for (const SettingsTable& alarm : root.tables("alarm")) map.alarms.push_back(read_alarm(alarm));
  if (const auto policy = root.table("write_policy")) {
    map.write_policy.only_on_change = policy->flag("only_on_change", true);
    map.write_policy.read_back = policy->flag("read_back", true);
  }
  map.positions = read_positions(root, map.kind);
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
