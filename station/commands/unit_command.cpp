// SPDX-License-Identifier: Apache-2.0
#include "station/commands/unit_command.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "station/config/unit_type_file.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

base::Status print_units(const db::Catalog& catalog, const std::vector<db::UnitRow>& units, Output& output) {
  nlohmann::json list = nlohmann::json::array();
  std::vector<std::vector<std::string>> table = {{"unit", "type", "epoch", "runs"}};
  for (const db::UnitRow& unit : units) {
    const auto runs = catalog.runs({.unit = unit.serial, .campaign = {}, .run = {}});
    if (!runs) return base::forward_error(runs);
    list.push_back({{"unit", unit.serial}, {"type", unit.type}, {"epoch", unit.epoch}, {"runs", runs->size()}});
    table.push_back({unit.serial, unit.type, std::to_string(unit.epoch), std::to_string(runs->size())});
  }
  if (output.json()) return output.print_json({{"units", list}});
  output.print(text_table(table));
  return {};
}

}  // namespace

base::Status run_unit_list(const UnitListCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto units = catalog->units();
  if (!units) return base::forward_error(units);
  return print_units(*catalog, *units, output);
}

base::Status run_unit_show(const UnitShowCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto unit = catalog->unit(command.serial);
  if (!unit) return base::forward_error(unit);
  if (!*unit) {
    return base::bad_input(fmt::format("there is no unit '{}': 'soak unit list' shows them", command.serial),
                           catalog->data_folder().string());
  }
  return print_units(*catalog, {**unit}, output);
}

base::Status run_unit_add(const UnitAddCommand& command, Output& output) {
  if (command.serial.empty()) return base::bad_input("the serial number is empty", "SN");
  if (auto plain = check_carried_line(command.serial, "SN"); !plain) return plain;
  if (command.begin_epoch) {
    if (auto plain = check_text_line(*command.begin_epoch, "--begin-epoch"); !plain) return plain;
  }
  if (command.type) {
    if (auto type = stated_unit_type(*command.type); !type) return base::forward_error(type);
  }
  auto catalog = open_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  auto unit = catalog->ensure_unit(command.serial, command.type.value_or("generic"));
  if (!unit) return base::forward_error(unit);
  if (command.type && unit->type != *command.type) {
    return base::bad_input(
        fmt::format("unit '{}' is there already, of type '{}', not '{}'", command.serial, unit->type, *command.type),
        "--type");
  }
  if (command.begin_epoch) {
    unit =
        catalog->begin_epoch(command.serial, *command.begin_epoch, command.user.empty() ? user_name() : command.user);
    if (!unit) return base::forward_error(unit);
  }
  return print_units(*catalog, {*unit}, output);
}

}  // namespace soak::station
