// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "hal/maps/device_map.h"

namespace soak::hal {

/// What a register map lacks to work a device of its kind, one sentence each; empty = nothing. Of a fixture that is
/// told angles the reader of its [axes] tells it.
[[nodiscard]] std::vector<std::string> device_needs(const RegisterMap& map);

}  // namespace soak::hal
