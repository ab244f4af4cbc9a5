// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace soak::station {

/// What needs somebody, by a status document (docs/http-api.md): the list that it carries as `alarms`, the most urgent
/// first. Reads every other member of the document, and nothing else.
[[nodiscard]] nlohmann::json alarms_of(const nlohmann::json& status);

}  // namespace soak::station
