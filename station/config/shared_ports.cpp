// SPDX-License-Identifier: Apache-2.0
#include "station/config/shared_ports.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <utility>
#include <variant>

namespace soak::station {
namespace {

/// The serial port that a controller is at; nothing where it has another link.
std::optional<std::string> port_of(const hal::DeviceMap& map) {
  const auto* serial = std::get_if<hal::SerialAddress>(&map.link.address);
  return serial ? std::optional(serial->device) : std::nullopt;
}

std::vector<std::pair<std::string, hal::DeviceMap>> controllers_of(const StationConfig& config) {
  std::vector<std::pair<std::string, hal::DeviceMap>> controllers = {{"chamber", config.chamber}};
  if (config.fixture) controllers.emplace_back("fixture", *config.fixture);
  if (const auto* power = std::get_if<hal::DeviceMap>(&config.power)) controllers.emplace_back("power", *power);
  return controllers;
}

}  // namespace

std::vector<SharedPort> shared_ports(const StationConfig& config) {
  std::map<std::string, std::string> owners;
  std::vector<SharedPort> shared;
  for (const auto& [section, map] : controllers_of(config)) {
    const auto port = port_of(map);
    if (!port || port->empty()) continue;
    const auto [owner, is_new] = owners.try_emplace(*port, section);
    if (is_new) continue;
    shared.push_back({section, fmt::format("the serial port '{}' of the {} is that of the {} already", *port, section,
                                           owner->second)});
  }
  for (const Slot& slot : config.slots) {
    const auto* serial = std::get_if<hal::SerialAddress>(&slot.address);
    const auto owner = serial ? owners.find(serial->device) : owners.end();
    if (owner == owners.end()) continue;
    shared.push_back({"slot", fmt::format("the serial port '{}' of slot {} is that of the {} already", serial->device,
                                          slot.name, owner->second)});
  }
  return shared;
}

}  // namespace soak::station
