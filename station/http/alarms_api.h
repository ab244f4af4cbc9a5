// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "station/alarms/alarm_sender.h"
#include "station/http/parameters.h"

/// Who is told of alarms: docs/http-api.md. `sender`: null where nobody is.
namespace soak::station {

/// GET /api/v1/alarms. Refuses (bad_input) any parameter.
[[nodiscard]] base::Result<nlohmann::json> alarms_answer(const AlarmSender* sender, const Parameters& parameters);

/// POST /api/v1/alarms/test. Refuses (bad_input) a body that is not the command's, and what AlarmSender::test() does.
[[nodiscard]] base::Result<nlohmann::json> test_alarms(AlarmSender* sender, const nlohmann::json& body);

}  // namespace soak::station
