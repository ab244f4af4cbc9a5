// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/http/parameters.h"
#include "station/lab/station_service.h"
#include "station/runs/run_archive.h"

namespace soak::station {

/// GET /api/v1/references: the register of references. Refuses (bad_input) any parameter.
[[nodiscard]] base::Result<nlohmann::json> references_answer(RunArchive& archive, const Parameters& parameters);

/// GET /api/v1/references/released?record_id=ID: the released models that would not keep the rule of release any more
/// if that reference were retired: {"released": [{"unit", "model"}, ..]}.
[[nodiscard]] base::Result<nlohmann::json> released_with_answer(RunArchive& archive, const Parameters& parameters);

/// GET /api/v1/key: what the station signs with. Refuses (bad_input) any parameter.
[[nodiscard]] base::Result<nlohmann::json> key_answer(RunArchive& archive, const Parameters& parameters);

/// Enters something into the laboratory's records: POST /api/v1/NAME with a JSON object.
struct RecordCommand {
  std::string_view name;
  /// Refuses (bad_input) a body that is not the command's: where == the name of the member.
  base::Result<nlohmann::json> (*carry_out)(const StationService& lab, RunArchive& archive, const nlohmann::json& body);
};

/// docs/http-api.md.
[[nodiscard]] const std::vector<RecordCommand>& record_commands();

}  // namespace soak::station
