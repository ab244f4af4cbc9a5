// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/report_data.h"

#include <algorithm>
#include <cmath>

namespace soak::calib {
namespace {

std::vector<ReportRow> residuals(const CurveData& data, const Curve& curve, double printed_per_unit) {
  std::vector<double> temps_c;
  for (const CurveRow& row : data.rows) temps_c.push_back(row.temp_c);
  std::vector<double> predicted(temps_c.size());
  evaluate(curve, temps_c, predicted);
  std::vector<ReportRow> rows;
  for (std::size_t i = 0; i < data.rows.size(); ++i) {
    const CurveRow& row = data.rows[i];
    rows.push_back({row.run, row.sweep, row.temp_c, row.value * printed_per_unit, row.standard_error * printed_per_unit,
                    (row.value - predicted[i]) * printed_per_unit, 0.0});
  }
  return rows;
}

void remove_level(std::vector<ReportRow>& rows) {
  double mean = 0.0;
  for (const ReportRow& row : rows) mean += row.residual / static_cast<double>(rows.size());
  for (ReportRow& row : rows) {
    row.value -= mean;
    row.residual -= mean;
  }
}

/// shape residual = residual − mean residual of the run
void set_shape_residuals(std::vector<ReportRow>& rows, std::size_t runs) {
  std::vector<double> sum(runs, 0.0);
  std::vector<double> count(runs, 0.0);
  for (const ReportRow& row : rows) {
    sum[static_cast<std::size_t>(row.run)] += row.residual;
    count[static_cast<std::size_t>(row.run)] += 1.0;
  }
  for (ReportRow& row : rows) {
    const auto run = static_cast<std::size_t>(row.run);
    row.shape_residual = row.residual - sum[run] / count[run];
  }
}

double rms(const std::vector<ReportRow>& rows, double ReportRow::* error) {
  double squares = 0.0;
  for (const ReportRow& row : rows) squares += row.*error * row.*error;
  return std::sqrt(squares / static_cast<double>(rows.size()));
}

/// At most kMostReportRows of the rows, at even steps.
std::vector<ReportRow> thinned(const std::vector<ReportRow>& rows) {
  if (rows.size() <= kMostReportRows) return rows;
  std::vector<ReportRow> kept;
  for (std::size_t k = 0; k < kMostReportRows; ++k) kept.push_back(rows[k * rows.size() / kMostReportRows]);
  return kept;
}

}  // namespace

ReportRows compare_rows(const CurveData& data, const Curve& curve, double printed_per_unit, bool relative) {
  std::vector<ReportRow> rows = residuals(data, curve, printed_per_unit);
  if (relative) remove_level(rows);
  set_shape_residuals(rows, data.runs.size());
  const ReportRow& worst = *std::max_element(rows.begin(), rows.end(), [](const ReportRow& a, const ReportRow& b) {
    return std::abs(a.residual) < std::abs(b.residual);
  });
  ReportRows result;
  result.runs = data.runs;
  result.total = rows.size();
  result.rmse_abs = rms(rows, &ReportRow::residual);
  result.rmse_shape = rms(rows, &ReportRow::shape_residual);
  result.worst_abs = std::abs(worst.residual);
  result.worst_temp_c = worst.temp_c;
  result.worst_run = data.runs[static_cast<std::size_t>(worst.run)];
  result.rows = thinned(rows);
  return result;
}

}  // namespace soak::calib
