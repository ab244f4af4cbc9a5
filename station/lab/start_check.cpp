// SPDX-License-Identifier: Apache-2.0
#include "station/lab/start_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <utility>

#include "base/hash.h"
#include "station/config/procedure.h"
#include "station/config/unit_type_file.h"
#include "station/import/slow_channel.h"
#include "station/io/text.h"
#include "station/lab/run_recorder.h"
#include "station/lab/suspenders.h"
#include "station/records/check_standard.h"

namespace soak::station {
namespace {

constexpr double kRoomTolerance_c = 10.0;
constexpr double kRangeShare = 0.9;

/// Slot → serial number: those of the request, else those of the configuration.
std::map<std::string, std::string> serials(const StartRequest& request, const StationConfig& config) {
  if (!request.units.empty()) return request.units;
  std::map<std::string, std::string> by_slot;
  for (const Slot& slot : config.slots) {
    if (!slot.unit.empty()) by_slot[slot.name] = slot.unit;
  }
  return by_slot;
}

/// `slot_of`: serial number → slot of those before.
base::Status check_serial(const std::string& slot, const std::string& serial,
                          std::map<std::string, std::string>& slot_of) {
  if (serial.empty()) return base::bad_input(fmt::format("slot {}: the serial number is empty", slot), "--unit");
  if (auto plain = check_carried_line(serial, "--unit"); !plain) return plain;
  const auto [other, is_new] = slot_of.emplace(serial, slot);
  if (is_new) return {};
  return base::bad_input(fmt::format("unit {} is given for slot {} and for slot {}: a unit can only be in one slot",
                                     serial, other->second, slot),
                         "--unit");
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

/// Fixture directions of the axes that the device sends, of a body that is mounted with its axes along `mounted`.
std::array<std::string, 3> sent_axes(const std::array<std::string, 3>& mounted,
                                     const std::array<std::string, 3>& sent) {
  std::array<std::string, 3> axes;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    axes[i] = mounted[static_cast<std::size_t>(sent[i][1] - 'X')];
    if (sent[i][0] == '-') axes[i][0] = axes[i][0] == '+' ? '-' : '+';
  }
  return axes;
}

/// The numbers of an AHRS400 are shares of the ranges on its label.
base::Status check_ranges(const Slot& slot, const calib::UnitType& type) {
  if (slot.decoder != hal::UnitDecoder::ahrs400 || (type.gyro_range_dps && type.accel_range_mps2)) return {};
  return base::bad_input(fmt::format("slot {}: the decoder ahrs400 needs the ranges that are printed on the unit: "
                                     "state gyro.range_dps and accel.range_mps2 in unit type '{}'",
                                     slot.name, type.name),
                         "unit type " + type.name);
}

base::Result<CheckedUnit> check_unit(const std::string& slot_name, const std::string& serial,
                                     const StationConfig& config, const db::Catalog& catalog) {
  const Slot* slot = slot_named(config, slot_name);
  if (!slot) return base::bad_input(fmt::format("the station has no slot '{}'", slot_name), "--unit");
  auto type = type_of(serial, *slot, config, catalog);
  if (!type) return base::forward_error(type);
  if (auto ranges = check_ranges(*slot, *type); !ranges) return base::forward_error(ranges);
  Slot own = *slot;
  if (type->axes) own.axes = sent_axes(own.axes, *type->axes);
  return CheckedUnit{std::move(own), serial, *std::move(type)};
}

std::vector<calib::UnitType> types_of(const std::vector<CheckedUnit>& units) {
  std::vector<calib::UnitType> types;
  for (const CheckedUnit& unit : units) types.push_back(unit.type);
  return types;
}

/// A turn of the fixture tells nothing where the run file cannot say it.
base::Status check_headings(const Procedure& procedure, const StationConfig& config) {
  if (procedure.turned_deg == 0.0 || (config.fixture && !config.fixture->azimuths_deg.empty())) return {};
  return base::bad_input(
      "the procedure turns the fixture about the vertical, but the headings of its positions are not known: state "
      "azimuths_deg in the fixture's register map",
      procedure.file);
}

base::Status check_name(const std::string& campaign) {
  if (campaign.empty()) return base::bad_input("the name of the campaign is empty", "--name");
  return check_text_line(campaign, "--name");
}

/// Tells one plan from another.
std::string fingerprint(const Plan& plan) {
  const std::string text = plan_document(plan).dump();
  return base::to_hex(base::sha256({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
}

}  // namespace

ReviewedStart review_start(const StartRequest& request, const StationConfig& config, const db::Catalog& catalog) {
  ReviewedStart reviewed;
  const auto note = [&](const auto& result) {
    if (!result) reviewed.mistakes.push_back(result.error());
    return result.has_value();
  };
  (void)note(check_name(request.campaign));
  auto procedure = parse_procedure(request.procedure_text, request.procedure_file);
  if (note(procedure)) {
    (void)note(check_headings(*procedure, config));
    reviewed.procedure = *std::move(procedure);
  }
  const auto by_slot = serials(request, config);
  if (by_slot.empty()) {
    (void)note(base::Status(base::bad_input(
        "no unit: enter the serial number of at least one (--unit SLOT=SERIAL, or unit in the station's configuration)",
        "--unit")));
  }
  std::map<std::string, std::string> slot_of;
  for (const auto& [slot, serial] : by_slot) {
    if (!note(check_serial(slot, serial, slot_of))) continue;
    if (auto unit = check_unit(slot, serial, config, catalog); note(unit)) reviewed.units.push_back(*std::move(unit));
  }
  if (reviewed.procedure) (void)note(check_ratings(*reviewed.procedure, types_of(reviewed.units), {}, {}));
  return reviewed;
}

base::Result<CheckedStart> check_start(const StartRequest& request, const StationConfig& config,
                                       const db::Catalog& catalog) {
  ReviewedStart reviewed = review_start(request, config, catalog);
  if (!reviewed.mistakes.empty()) return tl::unexpected(reviewed.mistakes.front());
  return CheckedStart{compile_plan(*reviewed.procedure, config.room_c), std::move(reviewed.units)};
}

double needed_bytes(const CheckedStart& checked, std::size_t first_step) {
  const Plan& plan = checked.plan;
  return estimated_bytes(plan.procedure.rate_hz, checked.units.size(), plan.remaining_s(first_step));
}

base::Status check_disk(const CheckedStart& checked, std::size_t first_step, const std::filesystem::path& folder) {
  const double needed = needed_bytes(checked, first_step);
  std::error_code error;
  const auto space = std::filesystem::space(folder, error);
  if (error) return {};
  const auto left = static_cast<double>(space.available);
  if (left <= needed) {
    return base::bad_input(
        fmt::format("the campaign will write about {:.0f} MB, the disk has {:.0f} MB left", needed * 1e-6, left * 1e-6),
        folder.string());
  }
  if (left >= Suspenders::kDiskEnough_bytes) return {};
  return base::fail(
      base::ErrorKind::internal,
      fmt::format("the disk has {:.0f} MB left, a campaign needs {:.0f} MB to begin or go on; below {:.0f} "
                  "MB it waits: make room",
                  left * 1e-6, Suspenders::kDiskEnough_bytes * 1e-6, Suspenders::kDiskLow_bytes * 1e-6),
      folder.string());
}

base::Status check_room(const CheckedStart& checked, std::size_t first_step, double room_c, double air_c) {
  const Plan& plan = checked.plan;
  const bool preflight = plan.runs[static_cast<std::size_t>(plan.steps[first_step].run)].preflight;
  if (!preflight || std::abs(air_c - room_c) <= kRoomTolerance_c) return {};
  return base::bad_input(fmt::format("the chamber is at {:+.1f} °C; the pre-flight needs the temperature of the room, "
                                     "{:+.1f} °C: wait until the chamber has reached it",
                                     air_c, room_c),
                         "state");
}

base::Status check_chamber(const CheckedStart& checked, const hal::Chamber& chamber) {
  const Procedure& procedure = checked.plan.procedure;
  if (procedure.ramp_rate_kpmin && !chamber.can_ramp()) {
    return base::bad_input("the procedure asks for a ramp rate, the chamber's register map has no ramp",
                           procedure.file);
  }
  return check_ratings(procedure, types_of(checked.units), chamber.min_set_point_c(), chamber.max_set_point_c());
}

base::Status check_fixture(const CheckedStart& checked, const hal::Fixture* fixture) {
  const Procedure& procedure = checked.plan.procedure;
  if (fixture == nullptr) {
    if (procedure.rate_positions.empty()) return {};
    return base::bad_input("the procedure has [rates], but the fixture is turned by hand", procedure.file);
  }
  const auto positions = fixture->positions();
  for (const Step& step : checked.plan.steps) {
    if (step.kind != StepKind::move || std::ranges::find(positions, step.position) != positions.end()) continue;
    return base::bad_input(
        fmt::format("the plan needs position {}, the fixture has {}", step.position, fmt::join(positions, ", ")),
        fixture->description());
  }
  for (const std::string& position : procedure.rate_positions) {
    for (const double rate_dps : procedure.rates_dps) {
      if (auto able = fixture->can_spin(position, rate_dps); !able) return able;
    }
  }
  for (const CheckedUnit& unit : checked.units) {
    for (const double rate_dps : procedure.rates_dps) {
      if (std::abs(rate_dps) < kRangeShare * unit.type.gyro_range_dps.value_or(kFastestFixture_dps)) continue;
      return base::bad_input(fmt::format("{:g} deg/s is too close to the end of the gyro range of unit {} ({:g} deg/s)",
                                         rate_dps, unit.serial, unit.type.gyro_range_dps.value_or(0.0)),
                             procedure.file);
    }
  }
  return {};
}

base::Result<JudgedReferences> check_references(const db::Catalog& catalog, const CheckedStart& checked,
                                                std::size_t first_step, double utc_s, double clock_rate) {
  return judge_references(catalog, {utc_s, utc_s + checked.plan.remaining_s(first_step) / clock_rate});
}

base::Result<std::optional<std::string>> note_on_check_standards(const db::Catalog& catalog,
                                                                 const CheckedStart& checked) {
  if (checked.plan.procedure.purpose != Purpose::calibration) return std::nullopt;
  std::vector<std::string> serials;
  for (const CheckedUnit& unit : checked.units) serials.push_back(unit.serial);
  return missing_check_standard(catalog, serials);
}

std::string begun_by(const std::string& user, const std::string& queued_by) {
  return fmt::format("by {}{}", user, queued_by.empty() ? "" : ", queued by " + queued_by);
}

nlohmann::json start_document(const StartRequest& request, const CheckedStart& checked,
                              const std::vector<std::string>& notes) {
  nlohmann::json units = nlohmann::json::object();
  for (const CheckedUnit& unit : checked.units) units[unit.slot.name] = unit.serial;
  return {{"procedure_file", request.procedure_file},
          {"procedure_text", request.procedure_text},
          {"units", std::move(units)},
          {"user", request.user},
          {"queued_by", request.queued_by.empty() ? nlohmann::json() : nlohmann::json(request.queued_by)},
          {"notes", notes},
          {"plan_sha256", fingerprint(checked.plan)}};
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
    // Journals of earlier versions do not have it.
    const auto queued_by = document.value("queued_by", nlohmann::json());
    if (!queued_by.is_null()) request.queued_by = queued_by;
    return request;
  } catch (const nlohmann::json::exception& error) {
    return base::corrupt(fmt::format("the journal of campaign '{}' cannot be read: {}", row.name, error.what()));
  }
}

base::Result<WayBack> way_to_resume(const db::Catalog& catalog, const db::CampaignRow& row, double room_c) {
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
  const Plan plan = compile_plan(*procedure, room_c);
  const auto document = nlohmann::json::parse(row.document, nullptr, false);
  if (document.value("plan_sha256", "") != fingerprint(plan)) {
    return base::bad_input(fmt::format("the procedure of campaign '{}' now compiles to another plan than at its start "
                                       "(another version of Soak or another room temperature): start a new campaign",
                                       row.name),
                           "state");
  }
  return way_back(plan, ended, room_c);
}

}  // namespace soak::station
