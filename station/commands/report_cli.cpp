// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/commands/frame.h"
#include "station/commands/report_command.h"

namespace soak::station::cli {

void register_report(CLI::App& program, Request& request) {
  const auto options = std::make_shared<ReportCommand>();
  CLI::App* command = add_command(program, request, "report", "Write what is known of a unit as one HTML page",
                                  "soak report --unit SN0042 -o SN0042.html --limits limits.toml", true);
  command->add_option("--unit", options->unit, "Serial number of the unit")->required()->type_name("SN");
  command->add_option("-o,--output", options->file, "File to write")->required()->type_name("FILE");
  command->add_option("--model", options->model, "Model version (else the newest)")->type_name("V");
  command
      ->add_option("--limits", options->limits,
                   "Limits per sensor (TOML; else those of the unit's type), judged on fresh runs; without any the "
                   "verdict is info")
      ->type_name("FILE");
  command->callback([options, &request] {
    options->data = request.data;
    options->software = "soak " SOAK_VERSION;
    request.action = [options](Output& output) { return run_report(*options, output); };
  });
}

}  // namespace soak::station::cli
