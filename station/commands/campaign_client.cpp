// SPDX-License-Identifier: Apache-2.0
#include "station/commands/campaign_client.h"

#include <cstdlib>

namespace soak::station {

base::Result<Client> station_client(const StationCommand& command) {
  std::string text = command.station;
  if (const char* named = std::getenv("SOAK_STATION"); text.empty() && named != nullptr) text = named;
  if (text.empty()) text = "127.0.0.1:8088";
  auto address = parse_host_port(text);
  if (!address) return base::bad_input(address.error().message, "--station");
  return Client(*std::move(address));
}

}  // namespace soak::station
