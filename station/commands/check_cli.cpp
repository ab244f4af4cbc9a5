// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/commands/check_commands.h"
#include "station/commands/frame.h"

namespace soak::station::cli {
namespace {

using RecordAction = base::Status (*)(const CheckRecordCommand& command, Output& output);

/// `declare` and `end` take the same.
void add_record(CLI::App& command, Request& request, RecordAction run) {
  const auto options = std::make_shared<CheckRecordCommand>();
  command.add_option("unit", options->unit, "Serial number")->required()->type_name("UNIT");
  command.add_option("--reason", options->reason, "Why")->required()->type_name("TEXT");
  command.callback([options, run, &request] {
    options->data = request.data;
    request.action = [options, run](Output& output) { return run(*options, output); };
  });
}

void add_chart(CLI::App& group, Request& request) {
  const auto options = std::make_shared<CheckChartCommand>();
  CLI::App* command =
      add_command(group, request, "chart", "Control charts of the check standards, campaign by campaign",
                  "soak check chart --unit SN0001", true);
  command->add_option("--unit", options->unit, "One check standard (else all there are now)")->type_name("SN");
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_check_chart(*options, output); };
  });
}

}  // namespace

void register_check_standard(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "check", "Check standards: units that every campaign measures");
  add_record(*add_command(*group, request, "declare", "Make a unit a check standard",
                          "soak check declare SN0001 --reason 'stays in slot 1 of every campaign'", true),
             request, run_check_declare);
  add_record(*add_command(*group, request, "end", "End a unit's use as a check standard",
                          "soak check end SN0001 --reason 'dropped on 2027-03-02'", true),
             request, run_check_end);
  add_chart(*group, request);
}

}  // namespace soak::station::cli
