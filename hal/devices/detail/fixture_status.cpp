// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/detail/fixture_status.h"

#include <fmt/format.h>

namespace soak::hal {

FixtureStatus::FixtureStatus(const RegisterMap& map) {
  const auto& codes = map.quantities.at("status").codes;
  moving_ = codes.at("moving");
  standing_ = codes.at("standing");
  fault_ = codes.at("fault");
}

base::Result<bool> FixtureStatus::moving(const Controller& controller, double status) const {
  const auto code = static_cast<int>(status);
  if (code == fault_) return controller.fail("the fixture reports a fault");
  if (code == moving_) return true;
  if (code != standing_) {
    return controller.fail(fmt::format("status ({}) is {}: the map knows standing = {}, moving = {}, fault = {}",
                                       controller.place("status"), code, standing_, moving_, fault_));
  }
  return false;
}

}  // namespace soak::hal
