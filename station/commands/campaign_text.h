// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace soak::station {

/// "35 h 10 min", "4 min 20 s", "12 s".
[[nodiscard]] std::string duration_text(double seconds);

/// Where a campaign is: "run 2 of 5, step 31 of 240: soak at -20 °C". `campaign` is that of a status document.
[[nodiscard]] std::string step_text(const nlohmann::json& campaign);

/// What `soak campaign status` prints of a status document.
[[nodiscard]] std::string status_text(const nlohmann::json& status);

}  // namespace soak::station
