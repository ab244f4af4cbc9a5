// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/unit_type.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// What a report is made of, as far as it is calculated.
struct ReportInput {
  std::string document;  ///< of the stored model (model_document.h)
  UnitInput fitted;      ///< the runs that this model was fitted to, as far as they still count
  UnitInput fresh;       ///< runs that no fit has seen; may have no runs
  Limits limits;
  std::optional<std::string> limits_source;  ///< where they stand; absent: there are none, and nothing is judged
  std::vector<Warning> warnings;             ///< of those who collected the runs
};

/// The sections `summary`, `sensors` and `couplings` of a report (docs/schema/report.schema.json).
///
/// Rows are estimated anew from the segments (make_rows) and compared with the curve that the model *stores*: residuals
/// are those of what is deployed. Everything that the fit found out is taken over from the stored document verbatim;
/// keys that an older one lacks are absent. Fresh runs are compared with the same curve by verify(), and are never
/// among the rows of the fit. Where rows cannot be had any more (all runs void), `rows` is null and a warning says so.
/// Refuses what calibration_of() refuses.
[[nodiscard]] base::Result<nlohmann::json> report_json(const ReportInput& input);

}  // namespace soak::calib
