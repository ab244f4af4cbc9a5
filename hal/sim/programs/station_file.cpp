// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/programs/station_file.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "base/text.h"
#include "base/units.h"
#include "hal/sim/lab/inertial_unit.h"
#include "hal/sim/lab/lab.h"

namespace soak::hal::sim {
namespace {

namespace fs = std::filesystem;

/// A text within double quotes, as TOML and JSON both write it.
std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      result += fmt::format("\\u{:04x}", static_cast<int>(c));
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string unit_address(const UnitAddress& address) {
  if (const auto* port = std::get_if<int>(&address)) return fmt::format("host = \"127.0.0.1\"\nport = {}\n", *port);
  return fmt::format("device = {}\n", in_quotes(std::get<std::string>(address)));
}

std::string address_json(const UnitAddress& address) {
  const auto* port = std::get_if<int>(&address);
  return port ? fmt::format("{}", *port) : in_quotes(std::get<std::string>(address));
}

const char* map_of(ChamberKind kind) {
  switch (kind) {
    case ChamberKind::f4t:
    case ChamberKind::f4t_rtu:
      return "watlow-f4t.toml";
    case ChamberKind::eurotherm_2400:
      return "eurotherm-2400.toml";
    case ChamberKind::espec_p300:
      return "espec-p300.toml";
  }
  return "";
}

std::string chamber_section(const fs::path& maps, const LabServerOptions& options, const LabAddresses& addresses) {
  const fs::path map = maps / "chambers" / map_of(options.chamber);
  return fmt::format("[chamber]\nmap = {}\n{}\n", in_quotes(map.string()), unit_address(addresses.chamber_wire));
}

std::string device_section(std::string_view name, const fs::path& map, int port) {
  return fmt::format("[{}]\nmap = {}\nhost = \"127.0.0.1\"\nport = {}\n\n", name, in_quotes(map.string()), port);
}

const char* map_of(FixtureKind kind) {
  return kind == FixtureKind::two_axis ? "two-axis.toml" : "modbus-positioner.toml";
}

/// The place on Earth, where it turns. The six positions have one heading each whatever the fixture does; the two axes
/// stand on a base that has one.
std::string earth_lines(const CampaignConfig& config, const LabServerOptions& options) {
  if (!config.earth) return "";
  std::string text = fmt::format("latitude_deg = {}\n", base::shortest(config.earth->latitude_deg));
  if (options.kinds.fixture == FixtureKind::two_axis) {
    text += fmt::format("azimuth_deg = {}\n", base::shortest(config.earth->azimuth_deg));
  }
  return text;
}

/// How a station calls units of a kind: protocol, type, and the serial number that the unit itself tells.
struct UnitWords {
  const char* decoder;
  const char* type;
  std::string serial;
};

UnitWords words_of(UnitKind kind, std::uint32_t device_id) {
  switch (kind) {
    case UnitKind::xsens:
      break;
    case UnitKind::ahrs400:
      return {"ahrs400", "ahrs400", fmt::format("{}", device_id)};
    case UnitKind::vectornav:
      return {"vectornav", "vn-200", fmt::format("{:010}", device_id)};
  }
  return {"xsens", "mti-300", fmt::format("{:08X}", device_id)};
}

std::string slot_section(const Mounting& mounting, int number, const UnitWords& unit, const UnitAddress& address) {
  const auto& [x, y, z] = mounting.labels;
  return fmt::format(
      "\n[[slot]]\nname = \"{0}\"\n{1}decoder = \"{5}\"\naxes = [\"{2}\", \"{3}\", \"{4}\"]\npower_output = {0}\n"
      "unit = \"{6}\"\nunit_type = \"{7}\"\n",
      number, unit_address(address), x, y, z, unit.decoder, unit.serial, unit.type);
}

}  // namespace

std::string station_toml(const CampaignConfig& config, const LabServerOptions& options, const LabAddresses& addresses,
                         const std::string& maps) {
  const fs::path folder = fs::absolute(maps).lexically_normal();
  std::string text = fmt::format("# The laboratory that soaksim runs, seed {}.\n[clock]\nrate = {}\n\n", config.seed,
                                 base::shortest(options.rate));
  text += chamber_section(folder, options, addresses);
  text += device_section("fixture", folder / "fixtures" / map_of(options.kinds.fixture), addresses.fixture);
  const bool card_is_enough = config.units <= kRelayCardOutputs;
  const char* const relay = card_is_enough ? "modbus-relay.toml" : "modbus-relay-64.toml";
  text += device_section("power", folder / "power" / relay, addresses.relay);
  text += fmt::format("[unit_types]\nfolder = {}\n\n[site]\ngravity_mps2 = {}\n",
                      in_quotes((folder / "units").string()), base::shortest(base::kStandardGravity_mps2));
  text += earth_lines(config, options);
  for (std::size_t i = 0; i < addresses.units.size(); ++i) {
    const int number = static_cast<int>(i) + 1;
    const UnitWords unit = words_of(options.kinds.unit(number), device_id_of(number));
    text += slot_section(config.lab.mounting(number), number, unit, addresses.units[i]);
  }
  return text;
}

std::string addresses_json(const LabAddresses& addresses, const std::string& station_file) {
  std::string units;
  for (const UnitAddress& address : addresses.units) {
    units += units.empty() ? "" : ", ";
    units += address_json(address);
  }
  return fmt::format(
      "{{\"station\": {}, \"chamber\": {}, \"chamber_wire\": {}, \"fixture\": {}, \"relay\": {}, \"units\": [{}]}}\n",
      in_quotes(station_file), addresses.chamber, address_json(addresses.chamber_wire), addresses.fixture,
      addresses.relay, units);
}

base::Result<std::string> write_station_file(const std::string& folder, const std::string& text) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return base::bad_input("cannot make this folder (" + error.message() + ")", folder);
  const fs::path target = fs::absolute(folder) / "station.toml";
  const fs::path partial = fs::absolute(folder) / "station.toml.new";
  std::ofstream stream(partial, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (stream) fs::rename(partial, target, error);
  if (!stream || error) return base::fail(base::ErrorKind::internal, "cannot write this file", target.string());
  return target.string();
}

}  // namespace soak::hal::sim
