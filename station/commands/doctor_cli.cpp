// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/commands/doctor_command.h"
#include "station/commands/frame.h"

namespace soak::station::cli {

void register_doctor(CLI::App& program, Request& request) {
  const auto options = std::make_shared<DoctorCommand>();
  CLI::App* command =
      add_command(program, request, "doctor", "Look at devices, permissions, disk, database and clock of this computer",
                  "soak doctor --config station.toml", true);
  command->add_option("--config", options->config, "The station's configuration; without it no devices are looked at")
      ->type_name("FILE");
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_doctor(*options, output); };
  });
}

}  // namespace soak::station::cli
