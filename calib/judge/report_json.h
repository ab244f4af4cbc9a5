// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/estimate/curve_data.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/run.h"
#include "calib/vocabulary/unit_type.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// One estimate of a run beside the curve of a stored model, in the unit that results are printed in.
struct ReportRow {
  int run = 0;  ///< index into ReportRows::runs
  Sweep sweep = Sweep::unknown;
  double temp_c = 0.0;
  double value = 0.0;
  double standard_error = 0.0;  ///< 0 = not known
  double residual = 0.0;        ///< value − curve
  double shape_residual = 0.0;  ///< the same less the mean residual of its run
};

/// The estimates of some runs beside a stored curve. Figures are over all of them; `rows` holds at most
/// kMostReportRows, evenly taken where there are more.
struct ReportRows {
  std::vector<std::string> runs;  ///< names
  std::vector<ReportRow> rows;
  std::size_t total = 0;
  double rmse_abs = 0.0;
  double rmse_shape = 0.0;
  double worst_abs = 0.0;
  double worst_temp_c = 0.0;
  std::string worst_run;
};

/// What a page can draw of one curve without growing beyond what a browser likes.
inline constexpr std::size_t kMostReportRows = 1000;

/// Compares rows (not empty) with the curve that a model stores, whether or not it was fitted to them.
/// `printed_per_unit` takes the rows' unit to the printed one. `relative`: the curve has no level of its own, so the
/// rows are shifted together until their mean residual is 0.
[[nodiscard]] ReportRows compare_rows(const CurveData& data, const Curve& curve, double printed_per_unit,
                                      bool relative);

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
