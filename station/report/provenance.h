// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "db/catalog/catalog.h"
#include "station/report/runs_of_model.h"

namespace soak::station {

/// The section `provenance` of a report: each run of the unit's epoch with its content hash, how it was recorded, what
/// it is to the model, and what of it is void; the hash of the stored model document. `calibration` is that of `model`.
[[nodiscard]] base::Result<nlohmann::json> provenance_json(const db::Catalog& catalog, const db::ModelRow& model,
                                                           const calib::Calibration& calibration,
                                                           const RunsOfModel& runs);

}  // namespace soak::station
