// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "hal/register_map.h"

namespace soak::hal {

/// What a register map lacks to work a chamber, one sentence each; empty = nothing.
[[nodiscard]] std::vector<std::string> chamber_needs(const RegisterMap& map);

}  // namespace soak::hal
