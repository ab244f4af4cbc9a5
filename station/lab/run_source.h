// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace soak::station {

/// What the run files that soakd records say of their source.
inline constexpr std::string_view kRunSource = "soakd";

}  // namespace soak::station
