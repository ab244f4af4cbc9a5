// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "hal/devices/devices.h"
#include "settings/reader.h"

namespace soak::hal {

/// "HOST:PORT" under `key` of a section [link], or "HOST" where there is a usual port.
[[nodiscard]] TcpAddress read_host_port(const SettingsTable& link, std::string_view key,
                                        std::optional<int> usual_port = {});

}  // namespace soak::hal
