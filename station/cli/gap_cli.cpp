// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/cli/frame.h"
#include "station/commands/gap_commands.h"

namespace soak::station::cli {

void register_gap(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "gap", "What simulation and measurement disagree on, and which effect that is");
  const auto options = std::make_shared<GapFindCommand>();
  CLI::App* find = add_command(*group, request, "find", "Name the effect that a unit's model lacks",
                               "soak gap find --unit SN0042", true);
  find->add_option("--unit", options->unit, "Serial number of the unit")->required()->type_name("SN");
  find->add_option("--campaign", options->campaign, "Runs of this campaign only")->type_name("NAME");
  find->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_gap_find(*options, output); };
  });
}

}  // namespace soak::station::cli
