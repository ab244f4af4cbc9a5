// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "hal/maps/text_map.h"

namespace soak::hal {

/// What a text map lacks to work a device of its kind, one sentence each; empty = nothing.
[[nodiscard]] std::vector<std::string> text_needs(const TextMap& map);

}  // namespace soak::hal
