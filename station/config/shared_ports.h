// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "station/config/station_config.h"

namespace soak::station {

/// A serial port that something else owns already.
struct SharedPort {
  std::string section;  ///< of the configuration: "fixture", "power", "slot"
  std::string text;     ///< for people: which port, of whom, and whose it is
};

/// Everything that claims a serial port which chamber, fixture or power has: requests of the one would run into the
/// answers of the other. Two slots at one port are not among them.
[[nodiscard]] std::vector<SharedPort> shared_ports(const StationConfig& config);

}  // namespace soak::station
