// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "hal/maps/device_map.h"
#include "station/commands/chamber_address.h"
#include "station/commands/chamber_commands.h"

namespace soak::station {
namespace {

using nlohmann::json;

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

json document(const std::string& file, const hal::DeviceMap& map, const Abilities& can) {
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

std::string limit_text(const std::optional<double>& limit) { return limit ? fmt::format("{:g}", *limit) : "any"; }

std::string list_text(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::string policy_text(const hal::WritePolicy& policy) {
  return fmt::format("{}, {}", policy.only_on_change ? "only what changes" : "also what the controller holds already",
                     policy.read_back ? "read back" : "not read back");
}

std::string summary(const hal::DeviceMap& map, const Abilities& can) {
  std::string text = fmt::format("{}: {} over {}, {}, read every {:g} s\n", map.name, map.kind,
                                 speaks_modbus(map) ? "Modbus" : "lines of text", address_text(map), map.link.poll_s);
  const bool is_chamber = map.kind == "chamber";
  if (is_chamber) {
    text += fmt::format("set points  {} to {} °C, narrowed by the controller's own limits where the map reads them\n",
                        limit_text(can.min_c), limit_text(can.max_c));
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

}  // namespace

base::Status run_chamber_check(const ChamberCheckCommand& command, Output& output) {
  const auto map = hal::read_device_map(command.file, hal::MapUse::device);
  if (!map) return base::forward_error(map);
  const Abilities can = abilities_of(*map);
  if (output.json()) return output.print_json(document(command.file, *map, can));
  output.print(summary(*map, can));
  return {};
}

}  // namespace soak::station
