// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/config/unit_type_file.h"
#include "station/config/unit_type_json.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

/// soak unit list
struct UnitList final : CatalogCommand {
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak unit show SN
struct UnitShow final : CatalogCommand {
  std::string serial;

  void declare(OptionList& options) override { options.add("unit SN", &serial, "Serial number").required(); }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak unit add SN
struct UnitAdd final : Command {
  std::string serial;
  std::optional<std::string> type;         ///< of a unit that is new
  std::optional<std::string> begin_epoch;  ///< why the unit is another from now on: repaired, re-flashed
  std::string user;                        ///< who adds the unit or begins it; empty = the user that runs the program

  void declare(OptionList& options) override {
    options.add("unit SN", &serial, "Serial number").required();
    options.add("--type NAME", &type, "Type of a new unit (default: generic)");
    options.add("--begin-epoch REASON", &begin_epoch,
                "Begin the unit's next epoch, because it has changed (repair, new firmware)");
    options.add("--user NAME", &user, "Name for the record (default: the user that runs the program)");
  }
  base::Status run(Output& output) override;
};

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

base::Status UnitList::run_with(db::Catalog& catalog, Output& output) {
  const auto units = catalog.units();
  if (!units) return base::forward_error(units);
  return print_units(catalog, *units, output);
}

base::Status UnitShow::run_with(db::Catalog& catalog, Output& output) {
  const auto unit = find_unit(catalog, serial);
  if (!unit) return base::forward_error(unit);
  return print_units(catalog, {*unit}, output);
}

base::Status UnitAdd::run(Output& output) {
  if (auto plain = check_carried_line(serial, "SN"); !plain) return plain;
  if (begin_epoch) {
    if (auto plain = check_text_line(*begin_epoch, "--begin-epoch"); !plain) return plain;
  }
  if (type) {
    if (auto stated = stated_unit_type(*type); !stated) return base::forward_error(stated);
  }
  auto catalog = open_catalog(data);
  if (!catalog) return base::forward_error(catalog);
  auto unit = catalog->add_unit(serial, type.value_or("generic"), user_name(user));
  if (!unit) return base::forward_error(unit);
  if (type && unit->type != *type) {
    return base::bad_input(fmt::format("unit '{}' exists with type '{}', not '{}'", serial, unit->type, *type),
                           "--type");
  }
  if (begin_epoch) {
    unit = catalog->begin_epoch(serial, *begin_epoch, user_name(user));
    if (!unit) return base::forward_error(unit);
  }
  return print_units(*catalog, {*unit}, output);
}

/// soak type list
struct TypeList : Command {
  std::string folder;  ///< empty = default_unit_type_folder()

  void declare(OptionList& options) override;
  base::Status run(Output& output) override;
};

/// soak type show NAME
struct TypeShow final : TypeList {
  std::string name;

  void declare(OptionList& options) override {
    options.add("type NAME", &name, "Name").required();
    TypeList::declare(options);
  }
  base::Status run(Output& output) override;
};

void TypeList::declare(OptionList& options) {
  options.add("--types DIR", &folder,
              "Folder of unit types (default: $SOAK_PROCEDURES/units, else those that came with soak)");
}

std::string rating_text(const calib::UnitType& type) {
  if (!type.temp_min_c || !type.temp_max_c) return "not stated";
  return fmt::format("{:g} to {:g} °C", *type.temp_min_c, *type.temp_max_c);
}

std::string value_text(const nlohmann::json& value) {
  if (value.is_null()) return "-";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

base::Status TypeList::run(Output& output) {
  const std::filesystem::path path = folder.empty() ? default_unit_type_folder() : std::filesystem::path(folder);
  const auto types = read_unit_types(path);
  if (!types) return base::forward_error(types);
  nlohmann::json list = nlohmann::json::array();
  std::vector<std::vector<std::string>> table = {{"type", "rating"}};
  for (const calib::UnitType& type : *types) {
    list.push_back({{"name", type.name},
                    {"temp_min_c", number_or_null(type.temp_min_c)},
                    {"temp_max_c", number_or_null(type.temp_max_c)}});
    table.push_back({type.name, rating_text(type)});
  }
  if (output.json()) return output.print_json({{"folder", path.string()}, {"types", list}});
  output.print(text_table(table));
  return {};
}

base::Status TypeShow::run(Output& output) {
  const auto type = find_unit_type(folder, name);
  if (!type) return base::forward_error(type);
  const nlohmann::json document = type_document(*type);
  if (output.json()) return output.print_json({{"type", document}});
  std::string text;
  for (const auto& [key, value] : document.items()) text += fmt::format("{:<26} {}\n", key, value_text(value));
  output.print(text);
  return {};
}

}  // namespace

CommandGroup unit_commands() {
  return {"unit",
          "Units: add, list, show",
          {{"add", "Add a unit, or begin the next epoch of an existing one",
            "soak unit add SN0042 --begin-epoch 'board repaired'", std::make_shared<UnitAdd>()},
           {"list", "List all units", "soak unit list --json", std::make_shared<UnitList>()},
           {"show", "Show one unit", "soak unit show SN0042", std::make_shared<UnitShow>()}}};
}

CommandGroup type_commands() {
  return {"type",
          "Unit types: list, show",
          {{"list", "List all unit types", "soak type list", std::make_shared<TypeList>()},
           {"show", "Show one unit type", "soak type show mti-300", std::make_shared<TypeShow>()}}};
}
// use unit_command.cpp

}  // namespace soak::station
