// SPDX-License-Identifier: Apache-2.0
#include "station/commands/soakd_command_line.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <exception>
#include <iostream>
#include <string>

#include "station/http/daemon.h"

namespace soak::station::cli {
namespace {

int report(const base::Error& error) {
  std::cerr << "soakd: " << (error.where.empty() ? "" : error.where + ": ") << error.message << '\n';
  return static_cast<int>(error.kind);
}

int run_checked(int argc, char** argv) {
  DaemonOptions options;
  CLI::App program("Soak's station: drives chamber, fixture and units, records, serves the pages", "soakd");
  program.set_version_flag("--version", "soakd " SOAK_VERSION);
  program
      .add_option("--config", options.config,
                  "The station: devices and slots (docs/station-config.md); default: station.toml in the data folder")
      ->type_name("FILE");
  program
      .add_option("--listen", options.listen, "Address of pages and interface, port 0 = any (default 127.0.0.1:8088)")
      ->type_name("HOST:PORT");
  program
      .add_option("--data", options.data,
                  "Data folder (else the configuration's, else $SOAK_DATA, else $XDG_DATA_HOME/soak)")
      ->type_name("DIR");
  program.footer(
      "Runs until SIGTERM or Ctrl-C; a campaign is then driven to the safe state first, which takes as long as the\n"
      "chamber needs to room temperature. 'soak campaign' commands it, the page shows it.\n"
      "Example:\n  soakd --config /etc/soak/station.toml\n"
      "Exit status: 0 done, 1 failed, 2 wrong usage or configuration, 3 a device failed, 4 stored data are damaged.");
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    return program.exit(help_or_version, std::cout, std::cerr);
  } catch (const CLI::ParseError& error) {
    return report(
        {base::ErrorKind::bad_input, std::string(error.what()) + " ('soakd --help' shows the usage)", "command line"});
  }
  const auto status = run_daemon(options);
  return status ? 0 : report(status.error());
}

}  // namespace

int run_soakd(int argc, char** argv) {
  try {
    return run_checked(argc, argv);
  } catch (const std::exception& error) {
    return report({base::ErrorKind::internal, error.what(), "soakd"});
  }
}

}  // namespace soak::station::cli
