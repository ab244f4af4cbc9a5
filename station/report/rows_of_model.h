// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/judge/report_json.h"
#include "calib/model/document_parts.h"
#include "calib/vocabulary/unit_type.h"
#include "db/catalog/catalog.h"
#include "station/report/runs_of_model.h"

namespace soak::station {

/// Of which model, judged by which limits.
struct RowsRequest {
  std::string unit;                   ///< serial number
  std::optional<std::int32_t> model;  ///< version; absent = the newest
  calib::Limits limits;
  std::optional<std::string> source;  ///< of the limits; absent: those of the unit's type, if it has any
};

/// A stored model with the runs that it was fitted to and the fresh ones, ready for calib::report_json(), which needs
/// no catalog any more.
struct RowsOfModel {
  db::ModelRow model;
  calib::Calibration calibration;
  RunsOfModel runs;
  std::vector<calib::ModelTerm> terms;
  calib::ReportInput input;
};

/// Reads the segments of a model's runs; no samples. Refuses an unknown unit and one without such a model; a run file
/// that is missing is damage.
[[nodiscard]] base::Result<RowsOfModel> rows_of_model(const db::Catalog& catalog, const RowsRequest& request);

}  // namespace soak::station
