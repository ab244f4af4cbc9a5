// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "station/commands/campaign_commands.h"
#include "station/http/client.h"

namespace soak::station {

/// A client of the daemon that the command means. Refuses (bad_input) an address that is not one.
[[nodiscard]] base::Result<Client> station_client(const StationCommand& command);

}  // namespace soak::station
