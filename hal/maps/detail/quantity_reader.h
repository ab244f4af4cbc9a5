// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/maps/device_map.h"
#include "settings/reader.h"

namespace soak::hal {

inline constexpr Limits kAddress{0, 65535};
inline constexpr Limits kAnyNumber{-1e9, 1e9};

/// Numbers that one register of a type can hold.
[[nodiscard]] Limits content_limits(RegisterType type);

/// One table [quantity.NAME] of a register map.
[[nodiscard]] Quantity read_quantity(const SettingsTable& table);

}  // namespace soak::hal
