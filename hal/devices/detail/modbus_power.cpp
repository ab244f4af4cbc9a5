// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hal/devices/detail/controller.h"
#include "hal/devices/detail/mapped_power.h"
#include "hal/devices/devices.h"
#include "hal/maps/detail/device_needs.h"
#include "hal/maps/detail/map_check.h"
#include "hal/maps/detail/vocabulary.h"

namespace soak::hal {

base::Result<std::unique_ptr<UnitPower>> make_modbus_power(const RegisterMap& map) {
  if (auto status = require_kind(map, "power"); !status) return base::forward_error(status);
  if (const auto needs = device_needs(map); !needs.empty()) {
    return base::bad_input(fmt::format("{}", fmt::join(needs, "; ")), map.file);
  }
  return make_mapped_power(std::make_shared<Controller>(map), kOutput);
}

}  // namespace soak::hal
