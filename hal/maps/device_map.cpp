// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/device_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <variant>

#include "hal/maps/detail/device_needs.h"
#include "hal/maps/detail/map_format.h"

namespace soak::hal {
namespace {

using settings::Table;

/// A call that carries an action out waits that long.
constexpr double kLongestDelay_s = 10.0;

/// Whether the file says that its controller speaks text; what is wrong with it is told later.
bool speaks_text(std::string_view text, const std::string& file) {
  const auto reader = settings::Reader::parse(text, file);
  return reader && reader->root().has("protocol") && reader->root().text("protocol", "") == "text";
}

// --- [action]

/// The number that a step writes: its own, or that of a code of the quantity (null where the map has none).
double read_step_value(const Table& step, const Quantity* quantity) {
  if (step.has("code") == step.has("value")) step.refuse("", "a step needs either 'code' or 'value'");
  if (!step.has("code")) return step.number("value", kAnyNumber, 0.0);
  const std::string code = step.text("code");
  if (!quantity) return 0.0;
  const auto found = quantity->codes.find(code);
  if (found != quantity->codes.end()) return found->second;
  step.refuse("code", fmt::format("the quantity has no code '{}'", code));
  return 0.0;
}

void check_step(const Table& table, const ActionStep& step, const Quantity& quantity, const MapFormat& format) {
  const std::string_view key = table.has("code") ? "code" : "value";
  if (!quantity.writable()) {
    table.refuse("quantity", fmt::format("'{}' has no '{}'", step.quantity, format.write_key));
  } else if (step.value < quantity.min.value_or(step.value) || step.value > quantity.max.value_or(step.value)) {
    table.refuse(key, fmt::format("{} is beyond the limits of '{}'", step.value, step.quantity));
  } else if (!format.holds(quantity, step.value)) {
    table.refuse(key, fmt::format("{} does not fit the register of '{}'", step.value, step.quantity));
  }
}

ActionStep read_step(const Table& table, const DeviceMap& map, const MapFormat& format) {
  ActionStep step;
  step.quantity = table.text("quantity");
  const auto found = map.quantities.find(step.quantity);
  const Quantity* quantity = found == map.quantities.end() ? nullptr : &found->second;
  step.value = read_step_value(table, quantity);
  step.delay_s = table.number("delay_s", {0.0, kLongestDelay_s}, 0.0);
  if (quantity) {
    check_step(table, step, *quantity, format);
  } else {
    table.refuse("quantity", fmt::format("there is no quantity '{}'", step.quantity));
  }
  return step;
}

void read_actions(const Table& actions, const MapFormat& format, DeviceMap& map) {
  const std::set<std::string> known = known_actions(map);
  for (const std::string& name : actions.keys()) {
    std::vector<ActionStep>& steps = map.actions[name];
    double delays_s = 0.0;
    for (const Table& step : actions.tables(name)) {
      steps.push_back(read_step(step, map, format));
      delays_s += steps.back().delay_s;
    }
    if (steps.empty()) actions.refuse(name, fmt::format("action '{}' has no step", name));
    if (delays_s > kLongestDelay_s) {
      actions.refuse(name, fmt::format("the delays of '{}' add up to more than {} s", name, kLongestDelay_s));
    }
    if (!map.kind.empty() && !known.contains(name)) {
      actions.refuse(name, fmt::format("a device of kind \"{}\" has no action '{}'", map.kind, name));
    }
  }
}

// --- [quantity], [[probe]], [[alarm]], [write_policy]

/// A name that nothing asks for is most likely misspelt; a device reads what it asks for.
void check_names(const Table& quantities, const DeviceMap& map) {
  std::set<std::string> acted_on;
  for (const auto& [name, steps] : map.actions) {
    for (const ActionStep& step : steps) acted_on.insert(step.quantity);
  }
  for (const auto& [name, quantity] : map.quantities) {
    const bool asked_for = asks_for(map, name);
    if (asked_for && quantity.command) {
      quantities.refuse(name, fmt::format("'{}' is read as well: it cannot be a command", name));
    }
    if (asked_for || acted_on.contains(name)) continue;
    quantities.refuse(name, fmt::format("a device of kind \"{}\" does not use the quantity '{}', nor does an action",
                                        map.kind, name));
  }
}

void read_probes(const Table& root, const MapFormat& format, DeviceMap& map) {
  for (const Table& table : root.tables("probe")) {
    Probe& probe = map.probes.emplace_back();
    probe.name = table.text("name");
    probe.otherwise = table.text("otherwise");
    format.read_probe(table, probe);
  }
}

void read_alarms(const Table& root, const MapFormat& format, DeviceMap& map) {
  std::set<std::string> names;
  for (const Table& table : root.tables("alarm")) {
    AlarmRule& rule = map.alarms.emplace_back();
    rule.name = table.text("name");
    rule.outputs_off = table.flag("outputs_off", false);
    format.read_alarm(table, rule);
    if (!names.insert(rule.name).second) table.refuse("name", fmt::format("alarm '{}' is duplicated", rule.name));
  }
}

DeviceMap read_map(const Table& root, const MapFormat& format, MapUse use) {
  DeviceMap map;
  map.protocol = root.choice<MapProtocol>("protocol", {{"modbus", MapProtocol::modbus}, {"text", MapProtocol::text}},
                                          MapProtocol::modbus);
  map.name = root.text("name");
  map.kind = root.choice<std::string>("kind", format.kinds);
  if (const auto link = root.table("link", settings::kRequired)) map.link = format.read_link(*link);
  const Table quantities = root.section("quantity", settings::kRequired);
  for (const std::string& name : quantities.keys()) {
    if (const auto table = quantities.table(name)) map.quantities[name] = format.read_quantity(*table);
  }
  read_probes(root, format, map);
  if (map.kind == "fixture" && root.has("axes")) map.axes.emplace();
  read_actions(root.section("action"), format, map);
  if (!map.kind.empty()) check_names(quantities, map);
  read_alarms(root, format, map);
  const Table policy = root.section("write_policy");
  map.write_policy.only_on_change = policy.flag("only_on_change", map.write_policy.only_on_change);
  map.write_policy.read_back = policy.flag("read_back", map.write_policy.read_back);
  format.read_root(root, map);
  if (use == MapUse::device) {
    // One mistake that lists all that is lacking: it has no line of its own.
    const auto needs = device_needs(map);
    if (!needs.empty()) root.refuse("kind", fmt::format("{}", fmt::join(needs, "; ")));
  }
  return map;
}

}  // namespace

// --- what both formats use

TcpAddress read_host_port(const Table& link, std::optional<int> usual_port) {
  constexpr int last_port = 65535;
  const std::string text = link.text("tcp");
  const std::size_t colon = text.rfind(':');
  TcpAddress address{text.substr(0, colon), usual_port.value_or(0)};
  if (colon != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto [stop, failure] = std::from_chars(text.data() + colon + 1, end, address.port);
    if (failure != std::errc{} || stop != end) address.port = 0;
  }
  if (address.host.empty() || address.port < 1 || address.port > last_port) {
    link.refuse("tcp",
                fmt::format("'link.tcp' must be {}\"host:port\", not \"{}\"", usual_port ? "\"host\" or " : "", text));
  }
  return address;
}

SerialAddress read_serial_line(const Table& link, std::string_view device_key, const std::vector<int>& bauds) {
  constexpr int usual_baud = 9600;
  SerialAddress address;
  address.device = link.text(device_key);
  if (address.device.empty()) link.refuse(device_key, fmt::format("'link.{}' must name a serial device", device_key));
  address.baud = link.whole("baud", kAnyNumber, usual_baud);
  if (std::find(bauds.begin(), bauds.end(), address.baud) == bauds.end()) {
    link.refuse("baud", fmt::format("'link.baud' must be one of {}", fmt::join(bauds, ", ")));
  }
  return address;
}

void read_write_limits(const Table& table, Quantity& quantity) {
  quantity.min = table.optional_number("min", kAnyNumber);
  quantity.max = table.optional_number("max", kAnyNumber);
  if (quantity.min && quantity.max && *quantity.min > *quantity.max) table.refuse("min", "'min' is above 'max'");
}

// --- maps

base::Result<DeviceMap> parse_device_map(std::string_view text, const std::string& file, MapUse use) {
  const MapFormat& format = speaks_text(text, file) ? text_format() : modbus_format();
  auto map = settings::read(text, file, [&](const Table& root) { return read_map(root, format, use); });
  if (map) map->file = file;
  return map;
}

base::Result<DeviceMap> read_device_map(const std::string& file, MapUse use) {
  const auto text = settings::read_text(file);
  if (!text) return base::forward_error(text);
  return parse_device_map(*text, file, use);
}

LinkKind link_kind(const DeviceMap& map) {
  return std::holds_alternative<TcpAddress>(map.link.address) ? LinkKind::tcp : LinkKind::serial;
}

base::Status require_device(const DeviceMap& map, std::string_view kind) {
  if (map.kind != kind) {
    return base::bad_input(fmt::format("the map is of kind \"{}\", not \"{}\"", map.kind, kind), map.file);
  }
  const auto needs = device_needs(map);
  return needs.empty() ? base::Status{} : base::bad_input(fmt::format("{}", fmt::join(needs, "; ")), map.file);
}

}  // namespace soak::hal
