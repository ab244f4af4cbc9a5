// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/device_needs.h"

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "base/result.h"
#include "hal/maps/detail/map_check.h"
#include "hal/maps/detail/vocabulary.h"

namespace soak::hal {
namespace {

using Needs = std::vector<std::string>;

void note(const base::Status& status, Needs& needs) {
  if (status) return;
  const std::string& text = status.error().message;
  if (std::find(needs.begin(), needs.end(), text) == needs.end()) needs.push_back(text);
}

void note_writable(const RegisterMap& map, std::initializer_list<std::string_view> numbered, Needs& needs) {
  for (const auto& [name, quantity] : map.quantities) {
    if (is_numbered(name, numbered)) note(require_writable(map, name), needs);
  }
}

/// A switch is 1 and 0, or it has codes: then these two are asked for.
void note_switch_codes(const RegisterMap& map, std::initializer_list<std::string_view> numbered, Needs& needs) {
  for (const auto& [name, quantity] : map.quantities) {
    if (quantity.codes.empty() || !is_numbered(name, numbered)) continue;
    for (const char* code : {"on", "off"}) note(require_code(map, name, code), needs);
  }
}

Needs chamber_needs(const RegisterMap& map) {
  Needs needs;
  note(require_quantity(map, "air_c"), needs);
  note(require_writable(map, "set_point_c"), needs);
  const bool actual = map.quantities.contains("actual_mode");
  note(require_code(map, actual ? "actual_mode" : "control_mode", "auto"), needs);
  for (const auto& [action, mode] : {std::pair{"start", "auto"}, std::pair{"stop", "off"}}) {
    if (map.actions.contains(action)) continue;
    note(require_writable(map, "control_mode"), needs);
    note(require_code(map, "control_mode", mode), needs);
  }
  if (map.quantities.contains("ramp_rate")) note(require_writable(map, "ramp_rate"), needs);
  note_writable(map, {kChamberOutput}, needs);
  note_switch_codes(map, {kChamberOutput}, needs);
  return needs;
}

bool is_whole(const Quantity& quantity) {
  return quantity.type != RegisterType::f32 && quantity.scale == 1.0 && !quantity.decimals_register;
}

Needs fixture_needs(const RegisterMap& map) {
  Needs needs;
  if (map.axes) return needs;
  note(require_writable(map, "request"), needs);
  note(require_quantity(map, "position"), needs);
  const auto position = map.quantities.find("position");
  if (position != map.quantities.end() && !is_whole(position->second)) {
    needs.emplace_back(
        "[quantity.position] numbers the positions: a plain whole number without 'scale' and "
        "'decimals_register'");
  }
  for (const char* code : {"standing", "moving", "fault"}) note(require_code(map, "status", code), needs);
  return needs;
}

Needs power_needs(const RegisterMap& map) {
  Needs needs;
  note(require_writable(map, std::string(kOutput) + "1"), needs);
  note_writable(map, {kOutput, kSetVoltage, kCurrentLimit}, needs);
  note_switch_codes(map, {kOutput, kState}, needs);
  return needs;
}

}  // namespace

std::vector<std::string> device_needs(const RegisterMap& map) {
  if (map.kind == "chamber") return chamber_needs(map);
  if (map.kind == "fixture") return fixture_needs(map);
  return map.kind == "power" ? power_needs(map) : Needs();
}

}  // namespace soak::hal
