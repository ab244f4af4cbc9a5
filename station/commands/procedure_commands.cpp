// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include <fmt/ranges.h>
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/config/plan.h"
#include "station/config/procedure.h"
#include "station/config/unit_type_file.h"
#include "station/lab/run_recorder.h"

namespace soak::station {
namespace {

/// soak procedure check FILE
struct ProcedureCheck final : Command {
  std::string file;
  std::vector<std::string> types;  ///< unit types whose limits all must allow it; empty = one of all must
  std::string type_folder;         ///< empty = default_unit_type_folder(), which may be missing
  bool all_steps = false;          ///< list every step instead of one line per run

  void declare(OptionList& options) override {
    options.add("file FILE", &file, "Procedure").required();
    options
        .add("--type NAME", &types,
             "Check against this type's temperature limits; may be repeated (default: lists the types that allow it)")
        .one_each();
    options.add("--types DIR", &type_folder,
                "Folder of unit types (default: $SOAK_PROCEDURES/units, else those that came with soak)");
    options.add("--steps", &all_steps, "List every step instead of one line per run");
  }
  base::Status run(Output& output) override;
};

constexpr double kSecondsPerHour = 3600.0;

std::vector<std::string> names_of(const std::vector<calib::UnitType>& types) {
  std::vector<std::string> names;
  for (const calib::UnitType& type : types) names.push_back(type.name);
  return names;
}

/// The unit types that a procedure was checked against.
struct CheckedTypes {
  std::vector<calib::UnitType> allowing;  ///< it stays within their temperature limits
  std::vector<calib::UnitType> too_weak;
};

/// What the recordings of one unit take at most on the disk.
double estimated_unit_bytes(const Procedure& procedure, const Plan& plan) {
  double recorded_s = 0.0;
  for (const Step& step : plan.steps) {
    // A ramp is recorded while the temperature moves.
    const bool recorded = procedure.kind == ProcedureKind::ramp || step.kind == StepKind::record;
    if (recorded) recorded_s += step.estimate_s;
  }
  return estimated_bytes(procedure.rate_hz, 1, recorded_s);
}

nlohmann::json procedure_document(const Procedure& procedure, const Plan& plan, const CheckedTypes& types) {
  return {{"file", procedure.file},
          {"name", procedure.name},
          {"purpose", name_of(procedure.purpose)},
          {"runs", std::ranges::count(plan.runs, false, &PlannedRun::preflight)},
          {"visits", procedure.set_points_c.size()},
          {"steps", plan.steps.size()},
          {"estimate_h", plan.estimate_s() / kSecondsPerHour},
          {"estimate_unit_bytes", estimated_unit_bytes(procedure, plan)},
          {"set_points_c", procedure.set_points_c},
          {"reference_c", number_or_null(procedure.reference_c)},
          {"types", names_of(types.allowing)},
          {"types_too_weak", names_of(types.too_weak)},
          {"mistakes", nlohmann::json::array()}};
}

/// The positions that a run records in, in the order of their first recording.
std::string recorded_positions(const Plan& plan, const PlannedRun& run) {
  std::vector<std::string> seen;
  for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
    const Step& step = plan.steps[i];
    const bool is_new = std::find(seen.begin(), seen.end(), step.position) == seen.end();
    if (step.kind == StepKind::record && is_new) seen.push_back(step.position);
  }
  return fmt::format("{}", fmt::join(seen, " "));
}

std::vector<std::string> planned_run_row(const Plan& plan, const PlannedRun& run) {
  int visits = 0;
  double seconds = 0.0;
  for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
    visits = std::max(visits, plan.steps[i].visit + 1);
    seconds += plan.steps[i].estimate_s;
  }
  return {run.label, std::to_string(visits), std::to_string(run.last_step - run.first_step + 1),
          fmt::format("{:.1f}", seconds / kSecondsPerHour),
          run.preflight ? "pre-flight" : recorded_positions(plan, run)};
}

std::string plan_table(const Plan& plan) {
  std::vector<std::vector<std::string>> rows = {{"run", "visits", "steps", "hours", "positions"}};
  for (const PlannedRun& run : plan.runs) rows.push_back(planned_run_row(plan, run));
  return text_table(rows);
}

std::string step_list(const Plan& plan) {
  std::string text;
  for (std::size_t i = 0; i < plan.steps.size(); ++i) text += fmt::format("{:6}  {}\n", i, describe(plan, i));
  return text;
}

std::string reference_line(const Procedure& procedure) {
  if (!procedure.reference_c) return "no reference plateau\n";
  return fmt::format("reference plateau: each {} begins and ends at {:g} °C\n",
                     procedure.cycle_at_visit ? fmt::format("pass of {} runs", 1 + procedure.cycles) : "run",
                     *procedure.reference_c);
}

std::string rating_lines(const CheckedTypes& types) {
  if (types.allowing.empty()) return "no unit type was checked for its temperature limits\n";
  std::string text = fmt::format("within the temperature limits of {}\n", fmt::join(names_of(types.allowing), ", "));
  for (const calib::UnitType& type : types.too_weak) {
    text +=
        fmt::format("NOT within the limits of {}, {:g} to {:g} °C\n", type.name, *type.temp_min_c, *type.temp_max_c);
  }
  return text;
}

std::string procedure_text(const Procedure& procedure, const Plan& plan, const CheckedTypes& types) {
  const auto [coldest, warmest] = std::minmax_element(procedure.set_points_c.begin(), procedure.set_points_c.end());
  const double hours = plan.estimate_s() / kSecondsPerHour;
  return fmt::format(
      "{}: {}, kind {}, {} set points from {:g} to {:g} °C\n{}{}estimated {:.1f} h ({:.1f} days), at most {:.0f} MB of "
      "recordings for each unit\n",
      procedure.name, name_of(procedure.purpose), name_of(procedure.kind), procedure.set_points_c.size(), *coldest,
      *warmest, reference_line(procedure), rating_lines(types), hours, hours / 24.0,
      std::ceil(1e-6 * estimated_unit_bytes(procedure, plan)));
}

/// The types that the user named, also those that state no limits, which read_procedure() then reports.
base::Result<std::vector<calib::UnitType>> named_types(const ProcedureCheck& command) {
  std::vector<calib::UnitType> types;
  for (const std::string& name : command.types) {
    auto type = find_unit_type(command.type_folder, name);
    if (!type) return base::forward_error(type);
    types.push_back(std::move(*type));
  }
  return types;
}

/// All types that state limits; none where no folder was named and there is no default one.
base::Result<std::vector<calib::UnitType>> rated_types(const ProcedureCheck& command) {
  const std::filesystem::path folder =
      command.type_folder.empty() ? default_unit_type_folder() : std::filesystem::path(command.type_folder);
  std::error_code error;
  if (command.type_folder.empty() && !std::filesystem::is_directory(folder, error)) {
    return std::vector<calib::UnitType>();
  }
  auto types = read_unit_types(folder);
  if (!types) return types;
  std::erase_if(*types, [](const calib::UnitType& type) { return !type.temp_min_c || !type.temp_max_c; });
  return types;
}

/// All types that the user named must allow it; otherwise one is enough.
base::Result<CheckedTypes> checked_types(const ProcedureCheck& command) {
  if (!command.types.empty()) {
    auto named = named_types(command);
    if (!named) return base::forward_error(named);
    return CheckedTypes{std::move(*named), {}};
  }
  auto rated = rated_types(command);
  if (!rated) return base::forward_error(rated);
  const auto allows_it = [&](const calib::UnitType& type) { return read_procedure(command.file, {type}).has_value(); };
  const auto weak = std::ranges::stable_partition(*rated, allows_it);
  CheckedTypes types{{rated->begin(), weak.begin()}, {weak.begin(), weak.end()}};
  if (!types.allowing.empty()) return types;
  const auto procedure = read_procedure(command.file, {});
  if (!procedure) return base::forward_error(procedure);
  return CheckedTypes{std::move(types.too_weak), {}};
}

base::Status ProcedureCheck::run(Output& output) {
  const auto types = checked_types(*this);
  if (!types) return base::forward_error(types);
  const auto procedure = read_procedure(file, types->allowing);
  if (!procedure) return base::forward_error(procedure);
  const Plan plan = compile_plan(*procedure);
  if (output.json()) return output.print_json(procedure_document(*procedure, plan, *types));
  output.print(procedure_text(*procedure, plan, *types));
  output.print(all_steps ? step_list(plan) : plan_table(plan));
  return {};
}

}  // namespace

CommandGroup procedure_commands() {
  return {
      "procedure",
      "Procedures: check",
      {{"check", "Check a procedure: all mistakes with their lines; its plan and duration",
        "soak procedure check procedures/six-position-soak.toml --type mti-300", std::make_shared<ProcedureCheck>()}}};
}

}  // namespace soak::station
