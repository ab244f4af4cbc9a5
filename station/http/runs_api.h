// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/http/parameters.h"
#include "station/runs/run_archive.h"

namespace soak::station {

/// A question about stored runs: GET /api/v1/NAME.
struct RunQuestion {
  std::string_view name;
  /// Refuses (bad_input, where == the parameter's name) a parameter that is missing, wrong or not known.
  base::Result<nlohmann::json> (*answer)(RunArchive& runs, const Parameters& parameters);
};

/// docs/http-api.md.
[[nodiscard]] const std::vector<RunQuestion>& run_questions();

/// POST /api/v1/run/void. Refuses (bad_input) a body that is not the command's: where == the name of the member.
[[nodiscard]] base::Result<nlohmann::json> void_run(RunArchive& runs, const nlohmann::json& body);

}  // namespace soak::station
