// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/text.h"
#include "hal/devices/survey.h"
#include "hal/maps/device_map.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/lab/survey_json.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// soak chamber check FILE: what a map can do; fails (bad_input) with all mistakes of the map and their lines.
struct ChamberCheck final : Command {
  std::string file;

  void declare(OptionList& options) override {
    options.add("file FILE", &file, "Map of a chamber controller, a fixture or a power supply").required();
  }
  base::Status run(Output& output) override;
};

/// soak chamber probe FILE: what a live controller says, read without writing. Prints it also where some of it cannot
/// be used, and then fails (device).
struct ChamberProbe final : Command {
  std::string file;
  std::string tcp;     ///< empty = as the map says
  std::string serial;  ///< a serial device; empty = as the map says
  int baud = 0;        ///< of `serial`; 0 = as the map says, else 9600
  int unit = -1;       ///< Modbus unit; negative = as the map says

  void declare(OptionList& options) override {
    options.add("file FILE", &file, "Map of a chamber controller, a fixture or a power supply").required();
    options.add("--tcp HOST[:PORT]", &tcp, "Address of the controller, instead of the map's");
    options.add("--serial DEVICE", &serial, "Serial port of the controller, instead of the map's address");
    options.add("--baud N", &baud, "With --serial: baud rate (default: the map's, else 9600)")
        .one_of({"1200", "2400", "4800", "9600", "19200", "38400", "57600", "115200"});
    options.add("--unit N", &unit, "Modbus unit number (default: the map's)").range(0, 255);
  }
  base::Status run(Output& output) override;
};

constexpr int kModbusPort = 502;
constexpr int kUsualBaud = 9600;

/// `usual_port`: where the text names none; 0 = it must.
base::Result<hal::TcpAddress> parse_tcp_address(const std::string& text, int usual_port) {
  const std::size_t colon = text.rfind(':');
  hal::TcpAddress address{text.substr(0, colon), usual_port};
  if (colon != std::string::npos) {
    const auto port = base::parse_int(text.substr(colon + 1));
    address.port = port && *port >= 1 && *port <= 65535 ? static_cast<int>(*port) : 0;
  }
  if (!address.host.empty() && address.port != 0) return address;
  return base::bad_input(fmt::format("'{}' is not HOST:PORT", text), "--tcp");
}

base::Status set_tcp(const std::string& text, hal::DeviceMap& map) {
  const auto* stated = std::get_if<hal::TcpAddress>(&map.link.address);
  const bool is_modbus = map.protocol == hal::MapProtocol::modbus;
  const int usual_port = is_modbus ? kModbusPort : stated != nullptr ? stated->port : 0;
  const auto address = parse_tcp_address(text, usual_port);
  if (!address) return base::forward_error(address);
  map.link.address = *address;
  return {};
}

void set_serial(const ChamberProbe& command, hal::DeviceMap& map) {
  const auto* stated = std::get_if<hal::SerialAddress>(&map.link.address);
  hal::SerialAddress line = stated ? *stated : hal::SerialAddress{.device = "", .baud = kUsualBaud};
  line.device = command.serial;
  if (command.baud != 0) line.baud = command.baud;
  map.link.address = line;
}

/// Replaces the map's address by that of the command line. Fails (bad_input) for what is no address, and for a unit
/// number where the controller has none.
base::Status set_address(const ChamberProbe& command, hal::DeviceMap& map) {
  if (!command.tcp.empty() && !command.serial.empty())
    return base::bad_input("cannot be combined with --tcp", "--serial");
  if (command.baud != 0 && command.serial.empty())
    return base::bad_input("only valid together with --serial", "--baud");
  if (command.unit >= 0) {
    if (map.protocol == hal::MapProtocol::text) {
      return base::bad_input("a controller with a text protocol has no unit number", "--unit");
    }
    map.link.unit = command.unit;
  }
  if (!command.serial.empty()) set_serial(command, map);
  return command.tcp.empty() ? base::Status{} : set_tcp(command.tcp, map);
}

bool speaks_modbus(const hal::DeviceMap& map) { return map.protocol == hal::MapProtocol::modbus; }

/// What a device of the map can do.
struct Abilities {
  std::optional<double> min_c;
  std::optional<double> max_c;
  bool can_ramp = false;
  std::vector<std::string> quantities;
  std::vector<std::string> actions;
  std::vector<std::string> probes;
  std::vector<std::string> alarms;
  std::vector<std::string> outputs_off;  ///< of the alarms
  hal::WritePolicy policy;
};

Abilities abilities_of(const hal::DeviceMap& map) {
  Abilities can;
  if (const auto set_point = map.quantities.find("set_point_c"); set_point != map.quantities.end()) {
    can.min_c = set_point->second.min;
    can.max_c = set_point->second.max;
  }
  for (const auto& [name, quantity] : map.quantities) can.quantities.push_back(name);
  for (const auto& [name, steps] : map.actions) can.actions.push_back(name);
  for (const auto& probe : map.probes) can.probes.push_back(probe.name);
  for (const auto& alarm : map.alarms) {
    can.alarms.push_back(alarm.name);
    if (alarm.outputs_off) can.outputs_off.push_back(alarm.name);
  }
  can.can_ramp =
      map.quantities.contains("ramp_rate") && map.actions.contains("ramp_on") && map.actions.contains("ramp_off");
  can.policy = map.write_policy;
  return can;
}

json map_document(const std::string& file, const hal::DeviceMap& map, const Abilities& can) {
  return {{"file", file},
          {"name", map.name},
          {"kind", map.kind},
          {"protocol", speaks_modbus(map) ? "modbus" : "text"},
          {"address", address_text(map)},
          {"poll_s", map.link.poll_s},
          {"min_set_point_c", number_or_null(can.min_c)},
          {"max_set_point_c", number_or_null(can.max_c)},
          {"can_ramp", can.can_ramp},
          {"quantities", can.quantities},
          {"actions", can.actions},
          {"probes", can.probes},
          {"alarms", can.alarms},
          {"outputs_off", can.outputs_off},
          {"write_policy", {{"only_on_change", can.policy.only_on_change}, {"read_back", can.policy.read_back}}},
          {"mistakes", json::array()}};
}

std::string set_point_text(const std::optional<double>& limit) { return limit ? fmt::format("{:g}", *limit) : "any"; }

std::string list_text(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::string policy_text(const hal::WritePolicy& policy) {
  return fmt::format("{}, {}", policy.only_on_change ? "only changed values" : "also unchanged values",
                     policy.read_back ? "read back" : "not read back");
}

std::string map_text(const hal::DeviceMap& map, const Abilities& can) {
  std::string text = fmt::format("{}: {} over {}, {}, read every {:g} s\n", map.name, map.kind,
                                 speaks_modbus(map) ? "Modbus" : "lines of text", address_text(map), map.link.poll_s);
  const bool is_chamber = map.kind == "chamber";
  if (is_chamber) {
    text += fmt::format(
        "set points  {} to {} °C, or the controller's own limits if the map reads them and they are narrower\n",
        set_point_text(can.min_c), set_point_text(can.max_c));
    text += fmt::format("ramps       {}\n", can.can_ramp ? "by the controller" : "none");
  }
  text += fmt::format("quantities  {}\n", list_text(can.quantities));
  text += fmt::format("actions     {}\n", list_text(can.actions));
  text += fmt::format("probes      {}\n", list_text(can.probes));
  if (is_chamber) {
    text += fmt::format("alarms      {}\n", list_text(can.alarms));
    text += fmt::format("outputs off {}\n", can.outputs_off.empty() ? "by no alarm" : list_text(can.outputs_off));
  }
  text += fmt::format("writes      {}\n", policy_text(can.policy));
  return text;
}

base::Status ChamberCheck::run(Output& output) {
  const auto map = hal::read_device_map(file, hal::MapUse::device);
  if (!map) return base::forward_error(map);
  const Abilities can = abilities_of(*map);
  if (output.json()) return output.print_json(map_document(file, *map, can));
  output.print(map_text(*map, can));
  return {};
}

std::string probe_table(const hal::ChamberSurvey& survey) {
  std::vector<std::vector<std::string>> rows = {{"", "name", "found", "where", "trouble"}};
  for (const hal::SurveyEntry& entry : survey.entries) {
    rows.push_back(
        {kind_text(entry.kind), entry.name, entry.text.empty() ? "-" : entry.text, entry.place, entry.trouble});
  }
  return text_table(rows);
}

base::Status ChamberProbe::run(Output& output) {
  auto map = hal::read_device_map(file);
  if (!map) return base::forward_error(map);
  if (auto set = set_address(*this, *map); !set) return set;
  const auto survey = hal::survey_chamber(*map);
  if (!survey) return base::forward_error(survey);
  if (output.json()) {
    if (auto printed = output.print_json(survey_document(*map, *survey)); !printed) return printed;
  } else {
    output.print(fmt::format("{}\n{}", survey->description, probe_table(*survey)));
  }
  if (survey->sound()) return {};
  return base::fail(base::ErrorKind::device, "first correct what is listed under 'trouble'", survey->description);
}

}  // namespace

CommandGroup chamber_commands() {
  return {"chamber",
          "Chambers: check a map, probe a live one, make it safe",
          {{"check", "Check the map of a controller: list its mistakes, or what it provides",
            "soak chamber check procedures/chambers/watlow-f4t.toml", std::make_shared<ChamberCheck>()},
           {"probe", "Read a live controller by its map: all values and alarms; writes nothing",
            "soak chamber probe procedures/chambers/watlow-f4t.toml --tcp 192.168.7.20",
            std::make_shared<ChamberProbe>()}}};
}

}  // namespace soak::station
