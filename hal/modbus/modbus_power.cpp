// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>

#include "hal/devices.h"
#include "hal/maps/vocabulary.h"
#include "hal/modbus/controller.h"
#include "hal/modbus/map_check.h"
#include "hal/power/mapped_power.h"

namespace soak::hal {

base::Result<std::unique_ptr<UnitPower>> make_modbus_power(const RegisterMap& map) {
  if (auto status = require_kind(map, "power"); !status) return base::forward_error(status);
  if (auto status = require_writable(map, std::string(kOutput) + "1"); !status) return base::forward_error(status);
  for (const auto& [name, quantity] : map.quantities) {
    if (!is_numbered(name, {kOutput, kSetVoltage, kCurrentLimit})) continue;
    if (auto status = require_writable(map, name); !status) return base::forward_error(status);
  }
  return make_mapped_power(std::make_shared<Controller>(map), kOutput);
}

}  // namespace soak::hal
