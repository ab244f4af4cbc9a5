// SPDX-License-Identifier: Apache-2.0
// What a register map has that a text map has not: registers and the functions that read and write them.
#include <fmt/format.h>

#include <algorithm>

#include "hal/maps/detail/fixture_axes.h"
#include "hal/maps/detail/map_format.h"
#include "hal/maps/detail/registers.h"

namespace soak::hal {
namespace {

using settings::Limits;
using settings::Table;

constexpr int kModbusPort = 502;
constexpr Limits kAddress{0, 65535};

/// Numbers that one register of a type can hold.
Limits content_limits(RegisterType type) {
  return type == RegisterType::i16 ? Limits{-32768, 32767} : Limits{0, 65535};
}

SerialAddress read_rtu_line(const Table& link) {
  // libmodbus takes any other baud rate for 9600.
  SerialAddress address = read_serial_line(link, "rtu", {1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200});
  address.parity = link.choice<char>("parity", {{"N", 'N'}, {"E", 'E'}, {"O", 'O'}}, 'N');
  address.stop_bits = link.whole("stop_bits", {1, 2}, 1);
  return address;
}

LinkSettings read_modbus_link(const Table& link) {
  constexpr int last_unit = 247;
  constexpr int direct_unit = 255;
  LinkSettings settings;
  const bool rtu = link.has("rtu");
  if (rtu == link.has("tcp")) link.refuse("", "'link' needs either 'tcp' or 'rtu'");
  if (rtu) settings.address = read_rtu_line(link);
  if (link.has("tcp")) settings.address = read_host_port(link, kModbusPort);
  settings.unit = link.whole("unit", {0, 255}, settings.unit);
  const bool reserved = settings.unit > last_unit && settings.unit != direct_unit;
  if (reserved || (rtu && (settings.unit == 0 || settings.unit == direct_unit))) {
    link.refuse("unit", fmt::format("'link.unit' must be from 1 to {}{}", last_unit, rtu ? "" : ", or 0 or 255"));
  }
  settings.response_timeout_s = link.number("response_timeout_s", {0.05, 30.0}, settings.response_timeout_s);
  settings.gap_s = link.optional_number("gap_s", {0.0, 0.5});
  if (settings.gap_s.value_or(0.0) > settings.response_timeout_s) {
    link.refuse("gap_s", "'link.gap_s' must not be longer than 'response_timeout_s'");
  }
  settings.max_block = link.whole("max_block", {2, 125}, settings.max_block);
  settings.poll_s = link.number("poll_s", {0.1, 60.0}, settings.poll_s);
  settings.second_connection = link.flag("second_connection", true);
  return settings;
}

std::map<std::string, int> read_register_codes(const Table& quantity, RegisterType type) {
  std::map<std::string, int> codes;
  const auto table = quantity.table("codes");
  if (!table) return codes;
  for (const std::string& name : table->keys()) codes[name] = table->whole(name, content_limits(type));
  if (type == RegisterType::f32 || quantity.has("scale") || quantity.has("decimals_register")) {
    quantity.refuse("codes", "'codes' belong to plain whole numbers: no type f32, 'scale' or 'decimals_register'");
  }
  return codes;
}

RegisterPlace read_register_place(const Table& table) {
  RegisterPlace place;
  place.address = table.whole("address", kAddress);
  place.type = table.choice<RegisterType>(
      "type", {{"u16", RegisterType::u16}, {"i16", RegisterType::i16}, {"f32", RegisterType::f32}});
  place.word_order = table.choice<WordOrder>(
      "word_order", {{"low_first", WordOrder::low_first}, {"high_first", WordOrder::high_first}}, WordOrder::low_first);
  if (place.type != RegisterType::f32 && table.has("word_order")) {
    table.refuse("word_order", "'word_order' belongs to type f32");
  }
  place.scale = table.number("scale", kAnyNumber, 1.0);
  if (place.scale == 0.0) table.refuse("scale", "'scale' must not be 0");
  place.decimals_register = table.optional_whole("decimals_register", kAddress);
  place.read_function = table.whole("read_function", {3, 4}, 3);
  place.write_function = table.optional_whole("write_function", {6, 16});
  if (place.write_function && *place.write_function != 6 && *place.write_function != 16) {
    table.refuse("write_function", "'write_function' must be 6 or 16");
  }
  return place;
}

void check_float(const Table& table, const RegisterPlace& place) {
  if (place.type != RegisterType::f32) return;
  if (place.address == static_cast<int>(kAddress.high)) {
    table.refuse("address", "a value of type f32 takes two registers");
  }
  if (place.write_function == 6) table.refuse("write_function", "a value of type f32 is written by function 16");
  if (place.decimals_register) table.refuse("decimals_register", "a value of type f32 has no 'decimals_register'");
}

Quantity read_register_quantity(const Table& table) {
  Quantity quantity;
  quantity.modbus = read_register_place(table);
  quantity.codes = read_register_codes(table, quantity.modbus.type);
  check_float(table, quantity.modbus);
  quantity.command = table.flag("command", false);
  read_write_limits(table, quantity);
  if (!quantity.writable()) {
    for (const char* key : {"min", "max"}) {
      if (table.has(key)) table.refuse(key, fmt::format("'{}' limits a write, but there is no 'write_function'", key));
    }
    if (quantity.command) table.refuse("command", "a command is written: it needs a 'write_function'");
  }
  if (quantity.command && quantity.modbus.decimals_register) {
    table.refuse("decimals_register", "a command has no 'decimals_register'");
  }
  return quantity;
}

void read_register_probe(const Table& table, Probe& probe) {
  probe.modbus.address = table.whole("address", kAddress);
  probe.modbus.type =
      table.choice<RegisterType>("type", {{"u16", RegisterType::u16}, {"i16", RegisterType::i16}}, RegisterType::u16);
  probe.modbus.expected = table.wholes("expected", content_limits(probe.modbus.type), settings::kRequired);
  if (table.has("expected") && probe.modbus.expected.empty()) table.refuse("expected", "'expected' names no number");
  if (table.has("link")) {
    probe.link = table.choice<LinkKind>("link", {{"tcp", LinkKind::tcp}, {"rtu", LinkKind::serial}});
  }
}

void read_register_alarm(const Table& table, AlarmRule& rule) {
  RegisterAlarm& alarm = rule.modbus;
  const Limits content = content_limits(RegisterType::u16);
  alarm.addresses = table.wholes("addresses", kAddress, settings::kRequired);
  if (table.has("addresses") && alarm.addresses.empty()) table.refuse("addresses", "'addresses' names no register");
  alarm.inactive = table.wholes("inactive", content);
  alarm.active = table.wholes("active", content);
  alarm.mask = table.optional_whole("mask", {1, 65535});
  if (int{table.has("inactive")} + int{table.has("active")} + int{table.has("mask")} != 1) {
    table.refuse("", "an alarm needs one of 'inactive', 'active' and 'mask'");
  } else if (!table.has("mask") && alarm.inactive.empty() && alarm.active.empty()) {
    const char* const list = table.has("active") ? "active" : "inactive";
    table.refuse(list, fmt::format("'{}' names no number", list));
  }
}

bool register_holds(const Quantity& quantity, double value) {
  // How many decimals a register has is known to the controller alone.
  return quantity.modbus.decimals_register || encode_value(quantity.modbus, value, 0);
}

std::vector<std::string> read_labels_of_positions(const Table& root, bool fixture) {
  std::vector<std::string> labels = root.texts("positions", fixture);
  if (!fixture && root.has("positions")) root.refuse("positions", "'positions' belongs to kind \"fixture\"");
  if (root.has("positions") && labels.empty()) root.refuse("positions", "'positions' names no position");
  std::vector<std::string> sorted = labels;
  std::sort(sorted.begin(), sorted.end());
  const auto twin = std::adjacent_find(sorted.begin(), sorted.end());
  if (twin != sorted.end()) root.refuse("positions", fmt::format("position '{}' is duplicated", *twin));
  return labels;
}

/// What a certificate says of the faces of a fixture without axes; one that is told angles is told better ones.
void read_leans(const Table& root, DeviceMap& map) {
  constexpr Limits kLean{-1.0, 1.0};
  const auto table = root.table("leans_deg");
  if (!table) return;
  if (map.kind != "fixture") return root.refuse("leans_deg", "'leans_deg' belongs to kind \"fixture\"");
  for (const std::string& label : table->keys()) {
    const std::vector<double> angles = table->numbers(label, kLean);
    if (std::find(map.positions.begin(), map.positions.end(), label) == map.positions.end()) {
      table->refuse(label, fmt::format("'{}' is none of 'positions'", label));
    } else if (angles.size() != 2) {
      table->refuse(
          label,
          fmt::format(
              "'{}' must be two angles in degrees: towards the fixture's next axis, and towards the one after it",
              label));
    } else {
      map.leans_deg[label] = {angles[0], angles[1]};
    }
  }
}

/// Positions of a fixture: by number, or by the angles of two axes.
void read_register_root(const Table& root, DeviceMap& map) {
  if (map.kind == "fixture" && root.has("axes")) return read_axes(root, map);
  map.positions = read_labels_of_positions(root, map.kind == "fixture");
  map.azimuths_deg = root.numbers("azimuths_deg", {-360.0, 360.0});
  if (root.has("azimuths_deg") && map.azimuths_deg.size() != map.positions.size()) {
    root.refuse("azimuths_deg", "'azimuths_deg' must have one number for each of 'positions'");
  }
  read_leans(root, map);
}

}  // namespace

const MapFormat& modbus_format() {
  static const MapFormat format = {
      MapProtocol::modbus, {{"chamber", "chamber"}, {"fixture", "fixture"}, {"power", "power"}},
      read_modbus_link,    read_register_quantity,
      read_register_probe, read_register_alarm,
      register_holds,      read_register_root,
      "write_function"};
  return format;
}

}  // namespace soak::hal
