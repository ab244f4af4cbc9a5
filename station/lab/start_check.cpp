// SPDX-License-Identifier: Apache-2.0
#include "station/lab/start_check.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <utility>

#include "station/lab/preflight.h"
#include "station/procedure/rating_check.h"
#include "station/unit_type_file.h"

namespace soak::station {
namespace {

/// Slot → serial number: those of the request, else those of the configuration.
base::Result<std::map<std::string, std::string>> serials(const StartRequest& request, const StationConfig& config) {
  std::map<std::string, std::string> by_slot = request.units;
  if (by_slot.empty()) {
    for (const Slot& slot : config.slots) {
      if (!slot.unit.empty()) by_slot[slot.name] = slot.unit;
    }
  }
  if (by_slot.empty()) {
    return base::bad_input("no unit: name them with --unit SLOT=SERIAL, or in the station's configuration", "--unit");
  }
  std::map<std::string, std::string> slot_of;
  for (const auto& [slot, serial] : by_slot) {
    if (serial.empty()) return base::bad_input(fmt::format("slot {}: the serial number is empty", slot), "--unit");
    const auto [other, is_new] = slot_of.emplace(serial, slot);
    if (!is_new) {
      return base::bad_input(
          fmt::format("unit {} stands in slot {} and in slot {}: each unit has one slot", serial, other->second, slot),
          "--unit");
    }
  }
  return by_slot;
}

const Slot* slot_named(const StationConfig& config, const std::string& name) {
  for (const Slot& slot : config.slots) {
    if (slot.name == name) return &slot;
  }
  return nullptr;
}

base::Result<calib::UnitType> type_of(const std::string& serial, const Slot& slot, const StationConfig& config,
                                      const db::Catalog& catalog) {
  const auto known = catalog.unit(serial);
  if (!known) return base::forward_error(known);
  const std::string name = *known ? (*known)->type : slot.unit_type;
  if (name.empty()) {
    return base::bad_input(fmt::format("the type of unit {} is not known: 'soak unit add {} --type NAME', or unit_type "
                                       "in slot {} of the configuration",
                                       serial, serial, slot.name),
                           "unit " + serial);
  }
  return read_unit_type(config.unit_types / (name + ".toml"));
}

base::Result<std::vector<CheckedUnit>> check_units(const StartRequest& request, const StationConfig& config,
                                                   const db::Catalog& catalog) {
  const auto by_slot = serials(request, config);
  if (!by_slot) return base::forward_error(by_slot);
  std::vector<CheckedUnit> units;
  for (const auto& [name, serial] : *by_slot) {
    const Slot* slot = slot_named(config, name);
    if (!slot) return base::bad_input(fmt::format("the station has no slot '{}'", name), "--unit");
    auto type = type_of(serial, *slot, config, catalog);
    if (!type) return base::forward_error(type);
    units.push_back({*slot, serial, *std::move(type)});
  }
  return units;
}

std::vector<calib::UnitType> types_of(const std::vector<CheckedUnit>& units) {
  std::vector<calib::UnitType> types;
  for (const CheckedUnit& unit : units) types.push_back(unit.type);
  return types;
}

base::Status check_disk(const Plan& plan, std::size_t units, const std::filesystem::path& folder) {
  const double needed = estimated_bytes(plan.procedure.rate_hz, units, plan.estimate_s());
  std::error_code error;
  const auto space = std::filesystem::space(folder, error);
  if (error || static_cast<double>(space.available) > needed) return {};
  return base::bad_input(fmt::format("the campaign will write about {:.1f} GB, the disk has {:.1f} GB left",
                                     needed * 1e-9, static_cast<double>(space.available) * 1e-9),
                         folder.string());
}

}  // namespace

base::Result<CheckedStart> check_start(const StartRequest& request, const StationConfig& config,
                                       const db::Catalog& catalog) {
  if (request.campaign.empty()) return base::bad_input("the name of the campaign is empty", "--name");
  const auto procedure = parse_procedure(request.procedure_text, request.procedure_file);
  if (!procedure) return base::forward_error(procedure);
  auto units = check_units(request, config, catalog);
  if (!units) return base::forward_error(units);
  if (auto rated = check_ratings(*procedure, types_of(*units), {}, {}); !rated) return base::forward_error(rated);
  CheckedStart checked{compile_plan(*procedure, config.room_c), *std::move(units)};
  if (auto room = check_disk(checked.plan, checked.units.size(), catalog.data_folder()); !room)
    return base::forward_error(room);
  return checked;
}

base::Status check_chamber(const CheckedStart& checked, const hal::Chamber& chamber) {
  const Procedure& procedure = checked.plan.procedure;
  if (procedure.ramp_rate_kpmin && !chamber.can_ramp()) {
    return base::bad_input("the procedure asks for a ramp rate, the chamber's register map has no ramp",
                           procedure.file);
  }
  return check_ratings(procedure, types_of(checked.units), chamber.min_set_point_c(), chamber.max_set_point_c());
}

nlohmann::json start_document(const StartRequest& request, const CheckedStart& checked) {
  nlohmann::json units = nlohmann::json::object();
  for (const CheckedUnit& unit : checked.units) units[unit.slot.name] = unit.serial;
  return {{"procedure_file", request.procedure_file},
          {"procedure_text", request.procedure_text},
          {"units", std::move(units)},
          {"user", request.user},
          {"plan", plan_document(checked.plan)}};
}

base::Result<StartRequest> request_of(const db::CampaignRow& row) {
  const auto document = nlohmann::json::parse(row.document, nullptr, false);
  try {
    StartRequest request;
    request.campaign = row.name;
    request.procedure_file = document.at("procedure_file");
    request.procedure_text = document.at("procedure_text");
    request.units = document.at("units").get<std::map<std::string, std::string>>();
    request.user = document.at("user");
    return request;
  } catch (const nlohmann::json::exception& error) {
    return base::corrupt(fmt::format("the journal of campaign '{}' cannot be read: {}", row.name, error.what()));
  }
}

base::Result<std::size_t> first_step_to_resume(const db::Catalog& catalog, const db::CampaignRow& row) {
  const auto request = request_of(row);
  if (!request) return base::forward_error(request);
  const auto procedure = parse_procedure(request->procedure_text, request->procedure_file);
  if (!procedure) return base::forward_error(procedure);
  const auto completed = catalog.completed_steps(row.name);
  if (!completed) return base::forward_error(completed);
  std::set<std::size_t> ended;
  for (const db::StepRow& step : *completed) {
    if (step.outcome != "failed") ended.insert(static_cast<std::size_t>(step.index));
  }
  const Plan plan = compile_plan(*procedure);
  for (const PlannedRun& run : plan.runs) {
    if (!ended.contains(run.last_step)) return run.first_step;
  }
  return base::bad_input(fmt::format("all runs of campaign '{}' are done", row.name), "state");
}

}  // namespace soak::station
