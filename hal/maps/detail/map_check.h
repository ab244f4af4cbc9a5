// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "base/result.h"
#include "hal/maps/device_map.h"

/// What a device asks of its map. The checks refuse (bad_input) with the map's file as place.
namespace soak::hal {

[[nodiscard]] base::Status require_kind(const RegisterMap& map, std::string_view kind);
[[nodiscard]] base::Status require_quantity(const RegisterMap& map, std::string_view name);
[[nodiscard]] base::Status require_writable(const RegisterMap& map, std::string_view name);
/// The quantity and that name among its codes.
[[nodiscard]] base::Status require_code(const RegisterMap& map, std::string_view name, std::string_view code);

}  // namespace soak::hal
