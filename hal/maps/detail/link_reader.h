// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/maps/device_map.h"
#include "settings/reader.h"

namespace soak::hal {

/// The section [link] of a register map.
[[nodiscard]] ModbusLinkSettings read_link(const SettingsTable& link);

}  // namespace soak::hal
