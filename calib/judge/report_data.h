// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/curve/calibration.h"
#include "calib/estimate/curve_data.h"
#include "calib/vocabulary/run.h"

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

}  // namespace soak::calib
