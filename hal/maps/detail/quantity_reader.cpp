// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/quantity_reader.h"

#include <fmt/format.h>

namespace soak::hal {
namespace {

std::map<std::string, int> read_codes(const SettingsTable& quantity, RegisterType type) {
  std::map<std::string, int> codes;
  const auto table = quantity.table("codes");
  if (!table) return codes;
  for (const std::string& name : table->keys()) codes[name] = table->whole(name, content_limits(type));
  if (type == RegisterType::f32 || quantity.has("scale") || quantity.has("decimals_register")) {
    quantity.refuse("codes", "'codes' belong to plain whole numbers: no type f32, 'scale' or 'decimals_register'");
  }
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

void check_command(const SettingsTable& table, const Quantity& quantity) {
  if (!quantity.command) return;
  if (!quantity.write_function) table.refuse("command", "a command is written: it needs a 'write_function'");
  if (quantity.decimals_register) table.refuse("decimals_register", "a command has no 'decimals_register'");
}

}  // namespace

Limits content_limits(RegisterType type) {
  return type == RegisterType::i16 ? Limits{-32768, 32767} : Limits{0, 65535};
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
  quantity.codes = read_codes(table, quantity.type);
  if (quantity.type == RegisterType::f32) check_float(table, quantity);
  quantity.command = table.flag("command", false);
  check_write_limits(table, quantity);
  check_command(table, quantity);
  return quantity;
}

}  // namespace soak::hal
