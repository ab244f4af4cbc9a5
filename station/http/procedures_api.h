// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "station/lab/station_service.h"
#include "station/runs/run_archive.h"

namespace soak::station {

/// POST /api/v1/procedures/new: a procedure like another one with some changes, written into the station's own folder
/// and entered into the event log; with `draft` only its text. docs/http-api.md. Refuses (bad_input) a body that is not
/// the command's, and what changed_procedure() and add_procedure() refuse: where == the name of the member.
[[nodiscard]] base::Result<nlohmann::json> new_procedure(const StationService& lab, RunArchive& archive,
                                                         const nlohmann::json& body);

}  // namespace soak::station
