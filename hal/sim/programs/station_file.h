// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/wires/lab_server.h"

namespace soak::hal::sim {

/// station.toml: what the station's daemon needs to know to work with the laboratory. `maps` is the folder of register
/// maps and unit types.
[[nodiscard]] std::string station_toml(const CampaignConfig& config, const LabServerOptions& options,
                                       const LabAddresses& addresses, const std::string& maps);

/// The addresses as one line of JSON, with the path of station.toml.
[[nodiscard]] std::string addresses_json(const LabAddresses& addresses, const std::string& station_file);

/// Writes `text` to `folder`/station.toml, so that a reader finds all of it or nothing; makes the folder. Errors: a
/// folder that cannot be made (bad_input), a file that cannot be written (internal).
[[nodiscard]] base::Result<std::string> write_station_file(const std::string& folder, const std::string& text);

}  // namespace soak::hal::sim
