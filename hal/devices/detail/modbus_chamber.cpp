// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hal/devices/detail/controller.h"
#include "hal/devices/detail/mapped_chamber.h"
#include "hal/devices/devices.h"
#include "hal/maps/detail/device_needs.h"
#include "hal/maps/detail/map_check.h"

namespace soak::hal {

base::Result<std::unique_ptr<Chamber>> make_modbus_chamber(const RegisterMap& map) {
  if (auto status = require_kind(map, "chamber"); !status) return base::forward_error(status);
  if (const auto needs = device_needs(map); !needs.empty()) {
    return base::bad_input(fmt::format("{}", fmt::join(needs, "; ")), map.file);
  }
  return make_mapped_chamber(std::make_unique<Controller>(map));
}

}  // namespace soak::hal
