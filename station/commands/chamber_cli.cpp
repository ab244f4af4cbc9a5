// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <set>

#include "station/commands/chamber_commands.h"
#include "station/commands/frame.h"

namespace soak::station::cli {
namespace {

void register_check(CLI::App& group, Request& request) {
  const auto options = std::make_shared<ChamberCheckCommand>();
  CLI::App* command = add_command(group, request, "check", "Every mistake of a controller's map; what the map can do",
                                  "soak chamber check procedures/chambers/watlow-f4t.toml", true);
  command->add_option("file", options->file, "Map of a chamber's controller, a fixture or unit power")
      ->required()
      ->type_name("FILE");
  command->callback([options, &request] {
    request.action = [options](Output& output) { return run_chamber_check(*options, output); };
  });
}

void register_probe(CLI::App& group, Request& request) {
  const auto options = std::make_shared<ChamberProbeCommand>();
  CLI::App* command =
      add_command(group, request, "probe", "Read a live controller by its map: all values and alarms; writes nothing",
                  "soak chamber probe procedures/chambers/watlow-f4t.toml --tcp 192.168.7.20", true);
  command->add_option("file", options->file, "Map of a chamber's controller, a fixture or unit power")
      ->required()
      ->type_name("FILE");
  command->add_option("--tcp", options->tcp, "Where the controller is, instead of the map's address")
      ->type_name("HOST[:PORT]");
  command->add_option("--serial", options->serial, "Serial port instead of the map's address")->type_name("DEVICE");
  command->add_option("--baud", options->baud, "Of --serial (else the map's, else 9600)")
      ->type_name("N")
      ->check(CLI::IsMember(std::set<int>{1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200}));
  command->add_option("--unit", options->unit, "Modbus unit number (else the map's)")
      ->type_name("N")
      ->check(CLI::Range(0, 255));
  command->callback([options, &request] {
    request.action = [options](Output& output) { return run_chamber_probe(*options, output); };
  });
}

}  // namespace

void register_chamber(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "chamber", "Maps of chambers: check, probe");
  register_check(*group, request);
  register_probe(*group, request);
}

}  // namespace soak::station::cli
