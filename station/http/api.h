// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/lab/station_service.h"
#include "station/runs/run_archive.h"

namespace soak::station {

/// A question: GET /api/v1/NAME. `parameter` is the one query parameter that it takes, empty for none.
struct ApiQuestion {
  std::string_view name;
  std::string_view parameter;
  /// `newest_log` is the number of the newest log entry.
  base::Result<nlohmann::json> (*answer)(StationService& lab, const std::optional<std::string>& parameter,
                                         std::int64_t newest_log);
};

/// A command: POST /api/v1/campaign/NAME with a JSON object.
struct ApiCommand {
  std::string_view name;
  /// Refuses (bad_input) a body that is not the command's: where == "body" or the name of the member.
  base::Result<nlohmann::json> (*carry_out)(StationService& lab, const nlohmann::json& body);
};

/// The interface but the event stream and stored runs (runs_api.h): docs/http-api.md.
[[nodiscard]] const std::vector<ApiQuestion>& api_questions();
[[nodiscard]] const std::vector<ApiCommand>& api_commands();

/// The body of a command: a JSON object.
[[nodiscard]] base::Result<nlohmann::json> parse_body(const std::string& text);

/// 400 bad_input, 409 bad_input of the state, 502 device, 503 internal with where == kBusy, 500 anything else.
[[nodiscard]] int http_status(const base::Error& error);
[[nodiscard]] std::string error_text(const base::Error& error);

/// One line; text that is not UTF-8 is mended, numbers that are not finite become null.
[[nodiscard]] std::string compact(const nlohmann::json& document);

}  // namespace soak::station
