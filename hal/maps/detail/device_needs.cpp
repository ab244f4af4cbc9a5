// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/device_needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace soak::hal {
namespace {

const std::set<std::string>& known_quantities(const DeviceMap& map) {
  static const std::set<std::string> chamber = {
      "air_c",       "set_point_c", "working_set_point_c", "output_percent",  "control_mode",
      "actual_mode", "ramp_rate",   "min_set_point_c",     "max_set_point_c", "air_rh_percent"};
  static const std::set<std::string> positions = {"request", "position", "status"};
  static const std::set<std::string> angles = {"outer_request", "outer_position", "inner_request", "inner_position",
                                               "status",        "rate_request",   "rate"};
  static const std::set<std::string> none;  // those of unit power are numbered
  if (map.kind == "chamber") return chamber;
  if (map.kind != "fixture") return none;
  return map.axes ? angles : positions;
}

bool is_whole(const Quantity& quantity) {
  const RegisterPlace& place = quantity.modbus;
  return place.type != RegisterType::f32 && place.scale == 1.0 && !place.decimals_register;
}

void need_chamber(const DeviceMap& map, Needs& needs) {
  needs.quantity("air_c");
  needs.writable("set_point_c");
  needs.code(map.quantities.contains("actual_mode") ? "actual_mode" : "control_mode", "auto");
  for (const auto& [action, mode] : {std::pair{"start", "auto"}, std::pair{"stop", "off"}}) {
    if (map.actions.contains(action)) continue;
    needs.writable("control_mode");
    needs.code("control_mode", mode);
  }
  if (map.quantities.contains("ramp_rate")) needs.writable("ramp_rate");
}

void need_positions(const DeviceMap& map, Needs& needs) {
  needs.writable("request");
  if (needs.quantity("position") && !is_whole(map.quantities.at("position"))) {
    needs.note(
        "[quantity.position] numbers the positions: a plain whole number without 'scale' and 'decimals_register'");
  }
  for (const char* code : {"standing", "moving", "fault"}) needs.code("status", code);
}

/// Outputs: `written` are given a value; `switched` are 1 and 0, or they have codes: then these two are asked for.
void need_outputs(const DeviceMap& map, std::initializer_list<std::string_view> written,
                  std::initializer_list<std::string_view> switched, Needs& needs) {
  for (const auto& [name, quantity] : map.quantities) {
    if (is_numbered(name, written)) needs.writable(name);
  }
  for (const auto& [name, quantity] : map.quantities) {
    if (quantity.codes.empty() || !is_numbered(name, switched)) continue;
    for (const char* code : {"on", "off"}) needs.code(name, code);
  }
}

}  // namespace

bool is_numbered(std::string_view name, std::initializer_list<std::string_view> beginnings) {
  for (const std::string_view beginning : beginnings) {
    if (!name.starts_with(beginning)) continue;
    const std::string_view number = name.substr(beginning.size());
    return !number.empty() && number.front() != '0' && number.find_first_not_of("0123456789") == number.npos;
  }
  return false;
}

bool asks_for(const DeviceMap& map, const std::string& quantity) {
  if (known_quantities(map).contains(quantity)) return true;
  if (map.kind == "chamber") return is_numbered(quantity, {kChamberOutput});
  return map.kind == "power" && is_numbered(quantity, {kOutput, kState, kCurrentTrip, kVoltageTrip, kSetVoltage,
                                                       kCurrentLimit, kVoltage, kCurrent});
}

std::set<std::string> known_actions(const DeviceMap& map) {
  if (map.kind == "chamber") return {"start", "stop", "ramp_on", "ramp_off"};
  return map.axes ? std::set<std::string>{"go", "spin"} : std::set<std::string>();
}

bool Needs::quantity(const std::string& name) {
  const bool there = map_.quantities.contains(name);
  if (!there) note(fmt::format("a map of kind \"{}\" needs [quantity.{}]", map_.kind, name));
  return there;
}

bool Needs::writable(const std::string& name) {
  if (!quantity(name)) return false;
  const bool can = map_.quantities.at(name).writable();
  const char* key = map_.protocol == MapProtocol::text ? "write" : "write_function";
  if (!can) note(fmt::format("[quantity.{}] needs a '{}'", name, key));
  return can;
}

bool Needs::code(const std::string& name, const std::string& code) {
  if (!quantity(name)) return false;
  const bool there = map_.quantities.at(name).codes.contains(code);
  const char* where = map_.protocol == MapProtocol::text ? "words" : "codes";
  if (!there) note(fmt::format("[quantity.{}] needs the code '{}' among its '{}'", name, code, where));
  return there;
}

void Needs::note(std::string sentence) {
  if (std::find(sentences_.begin(), sentences_.end(), sentence) == sentences_.end()) {
    sentences_.push_back(std::move(sentence));
  }
}

std::vector<std::string> device_needs(const DeviceMap& map) {
  Needs needs(map);
  if (map.kind == "chamber") {
    need_chamber(map, needs);
    need_outputs(map, {kChamberOutput}, {kChamberOutput}, needs);
  } else if (map.kind == "fixture" && !map.axes) {
    need_positions(map, needs);
  } else if (map.kind == "power") {
    needs.writable(std::string(kOutput) + "1");
    need_outputs(map, {kOutput, kSetVoltage, kCurrentLimit}, {kOutput, kState}, needs);
  }
  return needs.sentences();
}

}  // namespace soak::hal
