// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <string>

#include "station/commands/frame.h"
#include "station/commands/procedure_commands.h"
#include "station/commands/type_commands.h"

namespace soak::station::cli {
namespace {

void add_type_folder(CLI::App& command, std::string& folder) {
  command.add_option("--types", folder, "Folder of unit types (else $SOAK_PROCEDURES/units, else the checkout's own)")
      ->type_name("DIR");
}

void register_check(CLI::App& group, Request& request) {
  const auto options = std::make_shared<ProcedureCheckCommand>();
  CLI::App* command = add_command(group, request, "check", "Every mistake with its line; the plan and its hours",
                                  "soak procedure check procedures/six-position-soak.toml --type mti-300", true);
  command->add_option("file", options->file, "Procedure")->required()->type_name("FILE");
  command
      ->add_option("--type", options->types,
                   "Unit type whose temperature rating must bear it; may be repeated (else it says which types do)")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_type_folder(*command, options->type_folder);
  command->add_flag("--steps", options->all_steps, "List every step instead of one line per run");
  command->callback([options, &request] {
    request.action = [options](Output& output) { return run_procedure_check(*options, output); };
  });
}

void register_type_list(CLI::App& group, Request& request) {
  const auto options = std::make_shared<TypeListCommand>();
  CLI::App* command = add_command(group, request, "list", "All unit types", "soak type list", true);
  add_type_folder(*command, options->folder);
  command->callback(
      [options, &request] { request.action = [options](Output& output) { return run_type_list(*options, output); }; });
}

void register_type_show(CLI::App& group, Request& request) {
  const auto options = std::make_shared<TypeShowCommand>();
  CLI::App* command = add_command(group, request, "show", "One unit type", "soak type show mti-300", true);
  command->add_option("type", options->name, "Name")->required()->type_name("NAME");
  add_type_folder(*command, options->folder);
  command->callback(
      [options, &request] { request.action = [options](Output& output) { return run_type_show(*options, output); }; });
}

}  // namespace

void register_procedure(CLI::App& program, Request& request) {
  CLI::App* procedures = add_group(program, "procedure", "Procedures: check");
  register_check(*procedures, request);
  CLI::App* types = add_group(program, "type", "Unit types: list, show");
  register_type_list(*types, request);
  register_type_show(*types, request);
}

}  // namespace soak::station::cli
