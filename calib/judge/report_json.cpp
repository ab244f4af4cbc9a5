// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/report_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "calib/judge/detail/report_words.h"
#include "calib/judge/verification.h"
#include "calib/judge/warning_list.h"
#include "calib/model/model_document.h"

namespace soak::calib {
namespace {

using nlohmann::json;

// ---- rows beside a stored curve ----

std::vector<ReportRow> residual_rows(const CurveData& data, const Curve& curve, double printed_per_unit) {
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

void remove_mean_residual(std::vector<ReportRow>& rows) {
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

double rms_of(const std::vector<ReportRow>& rows, double ReportRow::* error) {
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

// ---- the document ----

json rows_json(const ReportRows& compared) {
  json points = json::array();
  for (const ReportRow& row : compared.rows) {
    points.push_back({{"run", row.run},
                      {"sweep", name_of(row.sweep)},
                      {"temp_c", row.temp_c},
                      {"value", row.value},
                      {"standard_error", row.standard_error},
                      {"residual", row.residual},
                      {"shape_residual", row.shape_residual}});
  }
  return {{"runs", compared.runs},           {"total", compared.total},
          {"rmse_abs", compared.rmse_abs},   {"rmse_shape", compared.rmse_shape},
          {"worst_abs", compared.worst_abs}, {"worst_temp_c", compared.worst_temp_c},
          {"worst_run", compared.worst_run}, {"points", std::move(points)}};
}

json compared_json(const std::optional<CurveData>& data, const Curve& curve, double factor, bool relative) {
  return data ? rows_json(compare_rows(*data, curve, factor, relative)) : json();
}

/// A number that is known only where rows are.
json known(const CurveVerification& curve, double value) { return curve.rows > 0 ? json(value) : json(); }

json curve_verification_json(const CurveVerification& curve, Verdict verdict, double factor) {
  return {{"verdict", name_of(verdict)},
          {"limit", curve.limit ? json(*curve.limit * factor) : json()},
          {"rows", curve.rows},
          {"worst_abs", known(curve, curve.worst_abs * factor)},
          {"worst_temp_c", known(curve, curve.worst_temp_c)},
          {"rmse_abs", known(curve, curve.rmse_abs * factor)},
          {"rmse_shape", known(curve, curve.rmse_shape * factor)},
          {"guard", known(curve, curve.guard * factor)},
          {"guard_factor", known(curve, curve.guard_factor)},
          {"covered", curve.covered},
          {"inside_pi95", curve.fresh_band ? json(curve.fresh_band->inside) : json()},
          {"inside_ci95", curve.shape_band ? json(curve.shape_band->inside) : json()}};
}

/// Of a sensor against fresh runs; null where no run tested it.
json verification_json(Sensor sensor, const std::optional<Verification>& verification) {
  if (!verification || !verification->sensors[index_of(sensor)]) return {};
  const SensorVerification& result = *verification->sensors[index_of(sensor)];
  return {{"verdict", name_of(result.verdict)},
          {"bias", curve_verification_json(result, result.bias_verdict, printed_per_si(sensor))},
          {"scale", result.scale ? curve_verification_json(*result.scale, result.scale->verdict, 1.0) : json()}};
}

std::vector<std::string> labels_of(const UnitInput& input) {
  std::vector<std::string> labels;
  for (const RunInput& run : input.runs) labels.push_back(run.label);
  return labels;
}

/// Labels, each with its campaign where there is more than one: V01 may be in both.
std::vector<std::string> run_names(const UnitInput& input) {
  const bool one =
      std::ranges::all_of(input.runs, [&](const RunInput& run) { return run.campaign == input.runs.front().campaign; });
  if (one) return labels_of(input);
  std::vector<std::string> names;
  for (const RunInput& run : input.runs) names.push_back(fmt::format("{} of campaign {}", run.label, run.campaign));
  return names;
}

/// Rows of runs, or none with a warning that says why.
std::optional<UnitRows> rows_of(const UnitInput& input, const char* code, WarningList& warnings) {
  if (input.runs.empty()) return std::nullopt;
  auto rows = make_rows(input);
  if (rows) return *std::move(rows);
  warnings.add({code, rows.error().message});
  return std::nullopt;
}

std::optional<Verification> verification_of(const Calibration& calibration, const ReportInput& input,
                                            WarningList& warnings) {
  if (input.fresh.runs.empty()) return std::nullopt;
  auto verification = verify(calibration, input.fresh, input.limits);
  if (!verification) {
    warnings.add({"verification_failed", "fresh runs could not be used: " + verification.error().message});
    return std::nullopt;
  }
  for (const Warning& warning : verification->warnings) warnings.add({warning.code, "fresh runs: " + warning.text});
  return *std::move(verification);
}

/// All that the parts of a report draw from.
struct Sources {
  const ReportInput& input;
  const json& fit;
  const Calibration& calibration;
  std::optional<UnitRows> fitted;
  std::optional<UnitRows> fresh;
  std::optional<Verification> verification;
};

json sensor_json(const Sources& from, const SensorCalibration& sensor, const json& fit) {
  const std::size_t s = index_of(sensor.sensor);
  const double factor = printed_per_si(sensor.sensor);
  const bool relative = fit.value("relative", false);
  const auto limit = from.input.limits.bias[s];
  const auto scale_limit = from.input.limits.scale_ppm[s];
  json entry = {{"unit", printed_unit(sensor.sensor)},
                {"fit", fit},
                {"rows", json()},
                {"scale_rows", json()},
                {"fresh", json()},
                {"limit", limit ? json(*limit * factor) : json()},
                {"scale_limit_ppm", scale_limit ? json(*scale_limit) : json()},
                {"verification", verification_json(sensor.sensor, from.verification)}};
  if (from.fitted) {
    entry["rows"] = compared_json(from.fitted->bias[s], sensor.bias, factor, relative);
    if (sensor.scale_ppm) {
      entry["scale_rows"] = compared_json(from.fitted->scale[s], *sensor.scale_ppm, 1.0, false);
    }
  }
  if (from.fresh) entry["fresh"] = compared_json(from.fresh->bias[s], sensor.bias, factor, relative);
  return entry;
}

json sensors_json(const Sources& from) {
  json sensors = json::object();
  for (const SensorCalibration& sensor : from.calibration.sensors) {
    const std::string name(name_of(sensor.sensor));
    sensors[name] = sensor_json(from, sensor, from.fit.at("sensors").at(name));
  }
  return sensors;
}

json summary_json(const Sources& from, WarningList warnings) {
  const Calibration& calibration = from.calibration;
  const VerdictSentence verdict =
      verdict_sentence(from.fit, from.input.limits_source.has_value(), from.verification, run_names(from.input.fresh));
  return {{"unit_type", calibration.unit_type},
          {"epoch", calibration.epoch},
          {"model_created_utc_s", calibration.created_utc_s},
          {"simulated", calibration.simulated},
          {"gravity_mps2", calibration.gravity_mps2},
          {"gravity", calibration.gravity_assumed ? "assumed" : "known"},
          {"verdict", verdict.verdict},
          {"sentence", verdict.sentence},
          {"limits", from.input.limits_source ? json(*from.input.limits_source) : json()},
          {"fresh_runs", labels_of(from.input.fresh)},
          {"warnings", warnings.take()}};
}

json couplings_json(const json& fit) {
  return {{"accel_misalignment_rad", fit.value("accel_misalignment_rad", json())},
          {"gyro_misalignment_rad", fit.value("gyro_misalignment_rad", json())},
          {"g_sensitivity_dps_per_g", fit.value("g_sensitivity_dps_per_g", json())},
          {"earth_rate_subtracted", fit.value("earth_rate_subtracted", json())},
          {"accel_even_order_g_per_g2", fit.value("accel_even_order_g_per_g2", json())},
          {"level_error", fit.value("level_error", json())}};
}

json sections(const ReportInput& input, const json& fit, const Calibration& calibration) {
  WarningList warnings;
  if (calibration.simulated) {
    warnings.add({"simulated", "the model comes from SIMULATED data: it is not of a real unit"});
  }
  for (const Warning& warning : input.warnings) warnings.add(warning);
  warnings.add_fit(fit);
  Sources from{input, fit, calibration, {}, {}, {}};
  from.fitted = rows_of(input.fitted, "rows_missing", warnings);
  from.verification = verification_of(calibration, input, warnings);
  // What cannot be made rows of, verify() has refused, and said so.
  if (from.verification) from.fresh = rows_of(input.fresh, "verification_failed", warnings);
  return {{"summary", summary_json(from, std::move(warnings))},
          {"sensors", sensors_json(from)},
          {"couplings", couplings_json(fit)}};
}

}  // namespace

ReportRows compare_rows(const CurveData& data, const Curve& curve, double printed_per_unit, bool relative) {
  std::vector<ReportRow> rows = residual_rows(data, curve, printed_per_unit);
  if (relative) remove_mean_residual(rows);
  set_shape_residuals(rows, data.runs.size());
  const ReportRow& worst = *std::max_element(rows.begin(), rows.end(), [](const ReportRow& a, const ReportRow& b) {
    return std::abs(a.residual) < std::abs(b.residual);
  });
  ReportRows result;
  result.runs = data.runs;
  result.total = rows.size();
  result.rmse_abs = rms_of(rows, &ReportRow::residual);
  result.rmse_shape = rms_of(rows, &ReportRow::shape_residual);
  result.worst_abs = std::abs(worst.residual);
  result.worst_temp_c = worst.temp_c;
  result.worst_run = data.runs[static_cast<std::size_t>(worst.run)];
  result.rows = thinned(rows);
  return result;
}

base::Result<json> report_json(const ReportInput& input) {
  const auto calibration = calibration_of(input.document);
  if (!calibration) return base::forward_error(calibration);
  try {
    return sections(input, json::parse(input.document).at("fit"), *calibration);
  } catch (const json::exception& error) {
    return base::corrupt(fmt::format("the stored model cannot be read: {}", error.what()), "station.db");
  }
}

}  // namespace soak::calib
