// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/commands/frame.h"
#include "station/commands/unit_command.h"

namespace soak::station::cli {
namespace {

void register_unit_list(CLI::App& group, Request& request) {
  CLI::App* command = add_command(group, request, "list", "All units", "soak unit list --json", true);
  command->callback(
      [&request] { request.action = [data = request.data](Output& output) { return run_unit_list({data}, output); }; });
}

void register_unit_show(CLI::App& group, Request& request) {
  const auto options = std::make_shared<UnitShowCommand>();
  CLI::App* command = add_command(group, request, "show", "One unit", "soak unit show SN0042", true);
  command->add_option("unit", options->serial, "Serial number")->required()->type_name("SN");
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_unit_show(*options, output); };
  });
}

void register_unit_add(CLI::App& group, Request& request) {
  const auto options = std::make_shared<UnitAddCommand>();
  CLI::App* command = add_command(group, request, "add", "Add a unit, or begin the next epoch of one that is there",
                                  "soak unit add SN0042 --begin-epoch 'board repaired'", true);
  command->add_option("unit", options->serial, "Serial number")->required()->type_name("SN");
  command->add_option("--type", options->type, "Type of a new unit (else generic)")->type_name("NAME");
  command
      ->add_option("--begin-epoch", options->begin_epoch, "Begin the unit's next epoch: why it is another from now on")
      ->type_name("REASON");
  command->add_option("--user", options->user, "Who begins it (else whoever is logged in)")->type_name("NAME");
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_unit_add(*options, output); };
  });
}

}  // namespace

void register_unit(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "unit", "Units: add, list, show");
  register_unit_add(*group, request);
  register_unit_list(*group, request);
  register_unit_show(*group, request);
}

}  // namespace soak::station::cli
