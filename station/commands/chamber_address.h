// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "hal/maps/device_map.h"
#include "station/commands/chamber_commands.h"

namespace soak::station {

/// Puts the address of a command line in place of the map's. Refuses (bad_input) what is no address, and a unit number
/// for a controller that has none.
[[nodiscard]] base::Status set_address(const ChamberProbeCommand& command, hal::DeviceMap& map);

/// "tcp 10.0.0.7:502", "serial /dev/ttyUSB0 at 9600 baud".
[[nodiscard]] std::string address_text(const hal::DeviceMap& map);

}  // namespace soak::station
