// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "hal/devices/detail/quantity_access.h"
#include "hal/devices/unit_power.h"

namespace soak::hal {

/// Unit power over the quantities of a controller, which others may work with too (a chamber's). `request`: kOutput or
/// kChamberOutput.
[[nodiscard]] std::unique_ptr<UnitPower> make_mapped_power(std::shared_ptr<QuantityAccess> controller,
                                                           std::string request);

}  // namespace soak::hal
