// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace CLI {
class App;
}

namespace soak::station::cli {

/// What the command line asked for. A command's parser sets `action`, which runs after all arguments have proved sound.
struct Request {
  std::string data;   ///< --data
  bool json = false;  ///< --json
  std::function<base::Status(Output&)> action;
};

/// A command is one function that adds its subcommand to the program's. To add one: write its options and work in
/// station/commands (no CLI11 there), its parser in station/cli/NAME_cli.cpp, and list it in command_line.cpp.
using Register = void (*)(CLI::App& program, Request& request);

void register_import(CLI::App& program, Request& request);
void register_runs(CLI::App& program, Request& request);
void register_unit(CLI::App& program, Request& request);
void register_calibration(CLI::App& program, Request& request);
void register_campaign(CLI::App& program, Request& request);
void register_procedure(CLI::App& program, Request& request);
void register_chamber(CLI::App& program, Request& request);
void register_signal(CLI::App& program, Request& request);
void register_key(CLI::App& program, Request& request);
void register_reference(CLI::App& program, Request& request);
void register_check_standard(CLI::App& program, Request& request);
void register_report(CLI::App& program, Request& request);
void register_gap(CLI::App& program, Request& request);
void register_doctor(CLI::App& program, Request& request);

/// Adds a subcommand with its one example, and --data; `prints_result` adds --json.
CLI::App* add_command(CLI::App& parent, Request& request, const std::string& name, const std::string& description,
                      const std::string& example, bool prints_result);

/// Adds a subcommand that only holds others.
CLI::App* add_group(CLI::App& parent, const std::string& name, const std::string& description);

}  // namespace soak::station::cli
