// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/result.h"
#include "station/config/alarm_config.h"
#include "station/http/setup_body.h"
#include "station/setup/setup_check.h"
#include "station/setup/setup_form.h"

/// What the page on which a station is set up, or its settings are changed, is told (docs/http-api.md).
namespace soak::station {

/// GET /api/v1/setup: what a station can be set up with. `kept`: maps of its own, which can be chosen, too.
[[nodiscard]] base::Result<nlohmann::json> setup_choices(const std::filesystem::path& file, const KeptMaps& kept = {});

/// The text and its mistakes.
[[nodiscard]] nlohmann::json setup_check_document(const std::string& text, const std::vector<SetupMistake>& mistakes);

/// What setup_form_of() takes, of a form without its secrets.
[[nodiscard]] nlohmann::json answers_document(const SetupForm& form, const KeptMaps& kept);

/// Sends a test over each way that was entered; `known`: who is told now, whose certificates of servers count. Takes
/// half a minute at most for each way. Refuses (bad_input) what entered_alarms() refuses, and nobody to tell.
[[nodiscard]] base::Result<nlohmann::json> send_entered(const SetupForm& form, const std::optional<AlarmConfig>& known,
                                                        const std::string& user, const std::atomic<bool>& stop);

}  // namespace soak::station
