// SPDX-License-Identifier: Apache-2.0
#include "hal/modbus/chamber_needs.h"

#include <algorithm>
#include <utility>

#include "base/result.h"
#include "hal/maps/vocabulary.h"
#include "hal/modbus/map_check.h"

namespace soak::hal {
namespace {

void note(const base::Status& status, std::vector<std::string>& needs) {
  if (status) return;
  const std::string& text = status.error().message;
  if (std::find(needs.begin(), needs.end(), text) == needs.end()) needs.push_back(text);
}

}  // namespace

std::vector<std::string> chamber_needs(const RegisterMap& map) {
  std::vector<std::string> needs;
  note(require_quantity(map, "air_c"), needs);
  note(require_writable(map, "set_point_c"), needs);
  const bool actual = map.quantities.contains("actual_mode");
  note(require_code(map, actual ? "actual_mode" : "control_mode", "auto"), needs);
  for (const auto& [action, mode] : {std::pair{"start", "auto"}, std::pair{"stop", "off"}}) {
    if (map.actions.contains(action)) continue;
    note(require_writable(map, "control_mode"), needs);
    note(require_code(map, "control_mode", mode), needs);
  }
  for (const auto& [name, quantity] : map.quantities) {
    if (name == "ramp_rate" || is_numbered(name, {kChamberOutput})) note(require_writable(map, name), needs);
  }
  return needs;
}

}  // namespace soak::hal
