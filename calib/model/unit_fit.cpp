// SPDX-License-Identifier: Apache-2.0
#include "calib/model/unit_fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <variant>

namespace soak::calib {
namespace {

constexpr double kReferenceTemp_c = 25.0;
/// So far visits of one plateau lie apart from run to run: nobody need be told.
constexpr double kSamePlateau_c = 0.5;

void shift(Curve& curve, double by) {
  if (auto* model = std::get_if<anfis::Model>(&curve)) {
    model->output.centre += by;
  } else if (auto* spline = std::get_if<SplineCurve>(&curve)) {
    for (auto& piece : spline->coefficients) piece[0] += by;
  } else if (auto* points = std::get_if<TableCurve>(&curve)) {
    for (double& value : points->values) value += by;
  }
}

/// Takes the level out of an accelerometer's bias curve: its value at 25 °C, or at the end of the range nearest to
/// that.
void make_relative(CurveFit& fit) {
  const double level = evaluate(fit.curve, kReferenceTemp_c);
  shift(fit.curve, -level);
  for (CurvePoint& point : fit.points) point.value -= level;
}

/// Tells where the bias was measured and the scale error was not, beyond the temperatures at which it was.
void warn_of_scale_range(Sensor sensor, const CurveData& bias, SensorFit& fit) {
  const double low_c = fit.scale->temp_min_c;
  const double high_c = fit.scale->temp_max_c;
  std::set<int> missing_c;
  for (const CurveRow& row : bias.rows) {
    const bool far = row.temp_c < low_c - kSamePlateau_c || row.temp_c > high_c + kSamePlateau_c;
    if (far) missing_c.insert(static_cast<int>(std::lround(row.temp_c)));
  }
  if (missing_c.empty()) return;
  fit.warnings.push_back(
      {"scale_range",
       fmt::format(
           "{}: its scale error was measured from {:.1f} to {:.1f} °C only, not at {} °C: there it is null, and "
           "the runtime holds it and says so",
           name_of(sensor), low_c, high_c, fmt::join(missing_c, ", "))});
}

}  // namespace

base::Result<SensorFit> fit_sensor(const UnitRows& rows, Sensor sensor, const CurveFitOptions& options) {
  const auto& bias = rows.bias[index_of(sensor)];
  const std::string name(name_of(sensor));
  if (!bias) return base::bad_input("no run gives this sensor", name);
  auto fitted = fit_curve(*bias, options, {name, std::string(printed_unit(sensor)), printed_per_si(sensor)},
                          rows.bias_type_b[index_of(sensor)]);
  if (!fitted) return base::forward_error(fitted);
  SensorFit fit;
  fit.bias = std::move(*fitted);
  fit.warnings = fit.bias.warnings;
  if (rows.relative_accel && !is_gyro(sensor)) {
    fit.relative = true;
    make_relative(fit.bias);
  }
  if (const auto& scale = rows.scale[index_of(sensor)]) {
    auto scale_fit = fit_curve(*scale, {}, {name + " scale", "ppm", 1.0}, rows.scale_type_b[index_of(sensor)]);
    if (!scale_fit) return base::forward_error(scale_fit);
    fit.scale = std::move(*scale_fit);
    warn_of_scale_range(sensor, *bias, fit);
    for (const Warning& warning : fit.scale->warnings) {
      if (warning.code != "few_runs") fit.warnings.push_back(warning);
    }
  }
  return fit;
}

}  // namespace soak::calib
