// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"

namespace soak::station {

struct DaemonOptions {
  std::filesystem::path config;  ///< as place_of_config() takes it; empty = station.toml in the data folder
  std::string listen;            ///< overrides the configuration's, where given
  std::string data;              ///< overrides the configuration's, where given
};

/// `soakd`: reads the configuration, takes the data folder for itself, serves pages and interface, carries out
/// campaigns until SIGTERM or SIGINT; a running campaign is then driven to the safe state first. Prints the address
/// that it serves, one line, once it does. Where there is no station.toml in the data folder, and no other one is
/// named, it first serves the page that writes it, and prints its address likewise. Where others than this machine can
/// reach it (docs/access.md) it speaks TLS, with a certificate of its own where the configuration names none. Errors:
/// wrong configuration, an address or data folder that is taken, others and no accounts (bad_input).
[[nodiscard]] base::Status run_daemon(const DaemonOptions& options);

}  // namespace soak::station
