// SPDX-License-Identifier: Apache-2.0
#include "station/commands/command_line.h"

#include <unistd.h>

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <array>
#include <exception>
#include <iostream>
#include <string_view>

#include "base/text.h"
#include "station/commands/frame.h"

namespace soak::station::cli {
namespace {

constexpr std::array kCommands = {register_import,         register_runs,      register_calibration, register_unit,
                                  register_campaign,       register_procedure, register_signal,      register_key,
                                  register_check_standard, register_report,    register_reference,   register_gap,
                                  register_chamber,        register_doctor};

/// Whether errors are wanted as JSON, also those of a command line that cannot be parsed.
bool asks_for_json(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--json") return true;
  }
  return false;
}

/// The innermost subcommand that was named.
const CLI::App& named_command(const CLI::App& program) {
  const auto named = program.get_subcommands();
  return named.empty() ? program : named_command(*named.front());
}

std::string full_name(const CLI::App& command) {
  return command.get_parent() == nullptr ? command.get_name()
                                         : full_name(*command.get_parent()) + " " + command.get_name();
}

int perform(const Request& request, Output& output) {
  const auto status = request.action(output);
  std::cout.flush();
  if (status && !std::cout) {
    output.print_error({base::ErrorKind::internal, "cannot write the results (is the disk full?)", "standard output"});
    return static_cast<int>(base::ErrorKind::internal);
  }
  if (status) return 0;
  output.print_error(status.error());
  return static_cast<int>(status.error().kind);
}

int run_checked(int argc, char** argv) {
  Request request;
  CLI::App program("Soak: thermal calibration of MEMS inertial units", "soak");
  program.set_version_flag("--version", "soak " SOAK_VERSION);
  program.require_subcommand(0, 1);
  program.footer(
      "'soak COMMAND --help' explains a command and shows an example.\n"
      "Exit status: 0 done, 1 failed, 2 wrong usage or bad input, 3 a device failed, 4 stored data are damaged, "
      "5 a unit fails its limits.");
  for (const Register add : kCommands) add(program, request);

  Output output(std::cout, std::cerr, asks_for_json(argc, argv), ::isatty(STDERR_FILENO) != 0);
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    return program.exit(help_or_version, std::cout, std::cerr);
  } catch (const CLI::ParseError& error) {
    const CLI::App& command = named_command(program);
    output.print_error({base::ErrorKind::bad_input,
                        std::string(error.what()) + " ('" + full_name(command) + " --help' shows the usage)",
                        "command line"});
    return static_cast<int>(base::ErrorKind::bad_input);
  }
  if (!request.action) {
    std::cout << named_command(program).help();
    return 0;
  }
  catch_signals();
  return perform(request, output);
}

/// The option that an argument is the value of, else its number.
std::string place_of(char** argv, int i) {
  const std::string_view before = i > 1 ? argv[i - 1] : "";
  return before.starts_with("-") ? std::string(before) : fmt::format("argument {}", i);
}

}  // namespace

int run(int argc, char** argv) {
  try {
    for (int i = 1; i < argc; ++i) {
      if (base::is_utf8(argv[i])) continue;
      Output(std::cout, std::cerr, asks_for_json(argc, argv), false)
          .print_error({base::ErrorKind::bad_input, "the argument is not UTF-8 text", place_of(argv, i)});
      return static_cast<int>(base::ErrorKind::bad_input);
    }
    return run_checked(argc, argv);
  } catch (const std::exception& error) {
    Output(std::cout, std::cerr, asks_for_json(argc, argv), false)
        .print_error({base::ErrorKind::internal, error.what(), "soak"});
    return static_cast<int>(base::ErrorKind::internal);
  }
}

CLI::App* add_command(CLI::App& parent, Request& request, const std::string& name, const std::string& description,
                      const std::string& example, bool prints_result) {
  CLI::App* command = parent.add_subcommand(name, description);
  command->footer("Example:\n  " + example);
  command->add_option("--data", request.data, "Data folder (else $SOAK_DATA, else $XDG_DATA_HOME/soak)")
      ->type_name("DIR");
  if (prints_result) command->add_flag("--json", request.json, "Print the result as one JSON document");
  return command;
}

CLI::App* add_group(CLI::App& parent, const std::string& name, const std::string& description) {
  CLI::App* group = parent.add_subcommand(name, description);
  group->require_subcommand(0, 1);
  return group;
}

}  // namespace soak::station::cli
