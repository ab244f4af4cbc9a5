// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

namespace soak::station {

/// What needs somebody, by a status document (docs/http-api.md): the list that it carries as `alarms`, the most urgent
/// first. Reads every other member of the document, and nothing else.
[[nodiscard]] nlohmann::json alarms_of(const nlohmann::json& status);

/// Whether an alarm with that code, about that, which is not in the status may last all the same: a campaign that
/// somebody has paused waits for nothing, whatever has become of the disk or the supply; and a unit that failed or was
/// dropped is not well because it was dropped since, or the campaign has ended.
[[nodiscard]] bool may_last_unseen(const nlohmann::json& status, std::string_view code, std::string_view about);

}  // namespace soak::station
