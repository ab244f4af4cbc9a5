// SPDX-License-Identifier: Apache-2.0
#include "station/setup/setup_choices.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <system_error>
#include <variant>

#include "hal/maps/device_map.h"
#include "settings/reader.h"
#include "station/setup/setup_form.h"

namespace soak::station {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kUsualBaud = 9600;

/// What is in a folder, in the order of names; a folder that is not there is empty.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code failure;
  for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end; entry.increment(failure)) {
    entries.push_back(entry->path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

bool names_serial_port(std::string_view name) {
  constexpr std::string_view kKinds[] = {"ttyUSB", "ttyACM", "ttyS", "ttyAMA", "ttyXR", "ttyMXUSB"};
  return std::ranges::any_of(kKinds, [&](std::string_view kind) {
    return name.starts_with(kind) && name.size() > kind.size() && name[kind.size()] >= '0' && name[kind.size()] <= '9';
  });
}

/// A port on the board that the kernel has found no chip for has the type 0.
bool has_hardware(const fs::path& drivers, const std::string& name) {
  const auto type = settings::read_text((drivers / name / "type").string());
  return !type || (*type != "0\n" && *type != "0");
}

/// What the configuration takes where no address is entered.
json defaults_of(const hal::DeviceMap& map) {
  const bool modbus = map.protocol == hal::MapProtocol::modbus;
  const auto* tcp = std::get_if<hal::TcpAddress>(&map.link.address);
  const auto* serial = std::get_if<hal::SerialAddress>(&map.link.address);
  json port;
  if (tcp != nullptr) port = tcp->port;
  if (modbus) port = kModbusPort;
  return {{"port", port},
          {"baud", serial != nullptr ? serial->baud : kUsualBaud},
          {"unit", modbus ? json(map.link.unit) : json()}};
}

}  // namespace

std::vector<SerialPort> serial_ports(const fs::path& devices, const fs::path& drivers) {
  std::vector<SerialPort> ports;
  std::set<std::string> named;
  std::error_code failure;
  for (const fs::path& link : entries_of(devices / "serial/by-id")) {
    const fs::path node = fs::weakly_canonical(link, failure);
    if (failure) continue;
    ports.push_back({link.string(), node.string()});
    named.insert(node.string());
  }
  for (const fs::path& node : entries_of(devices)) {
    const std::string name = node.filename().string();
    if (!names_serial_port(name) || named.contains(node.string()) || !has_hardware(drivers, name)) continue;
    ports.push_back({node.string(), node.string()});
  }
  return ports;
}

json map_choice(const fs::path& file, const std::string& choice) {
  const auto map = hal::read_device_map(file.string(), hal::MapUse::device);
  if (!map) return {};
  json shown = defaults_of(*map);
  shown["file"] = choice;
  shown["name"] = map->name;
  shown["protocol"] = map->protocol == hal::MapProtocol::modbus ? "modbus" : "text";
  return shown;
}

json map_choices(const fs::path& folder) {
  json maps = json::array();
  for (const fs::path& file : entries_of(folder)) {
    if (file.extension() != ".toml") continue;
    if (json choice = map_choice(file, file.filename().string()); !choice.is_null()) maps.push_back(std::move(choice));
  }
  return maps;
}

}  // namespace soak::station
