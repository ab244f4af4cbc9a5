// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "station/lab/lab.h"

namespace soak::station {

/// What the status is made of beside the lab itself.
struct StatusInput {
  const Lab& lab;
  std::string_view state;  ///< name of the engine's state
  std::string reason;
  std::size_t step = 0;  ///< present step of the plan
  double started_utc_s = 0.0;
  double step_started_s = 0.0;  ///< process time
  bool holding = false;         ///< waits for the chamber to answer
};

/// The document of GET /api/v1/status: docs/http-api.md.
[[nodiscard]] nlohmann::json status_document(const StatusInput& input);

}  // namespace soak::station
