// SPDX-License-Identifier: Apache-2.0
#include "calib/model/unit_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>
#include <variant>

#include "calib/curve/bump_curve.h"
#include "calib/curve/constant_fit.h"
#include "calib/model/deployed_terms.h"

namespace soak::calib {
namespace {

// The fits of one sensor.

constexpr double kLevelTemp_c = 25.0;
/// So far visits of one plateau lie apart from run to run: nobody need be told.
constexpr double kSamePlateau_c = 0.5;

void shift_curve(Curve& curve, double by) {
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
  const double level = evaluate(fit.curve, kLevelTemp_c);
  shift_curve(fit.curve, -level);
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
      {"scale_range", fmt::format("{}: its scale error was measured from {:.1f} to {:.1f} °C only, not at {} °C: there "
                                  "it is null; the runtime uses the nearest measured value and sets a flag",
                                  name_of(sensor), low_c, high_c, fmt::join(missing_c, ", "))});
}

/// A sensor of which all rows are of one temperature.
base::Result<SensorFit> constants_of(const UnitRows& rows, Sensor sensor) {
  const std::size_t s = index_of(sensor);
  const std::string name(name_of(sensor));
  if (rows.relative_accel) {
    return base::bad_input(
        fmt::format("{} distinct temperatures in one attitude: a thermal model needs at least {}, constants need the "
                    "unit turned (six positions, or ten attitudes and more at rest)",
                    distinct_temperatures(*rows.bias[s]), kCurveTemperatures),
        name);
  }
  auto bias = fit_constant(*rows.bias[s], {name, std::string(printed_unit(sensor)), printed_per_si(sensor)},
                           rows.validity[s], rows.validity[s].bias_per_k, rows.bias_type_b[s]);
  if (!bias) return base::forward_error(bias);
  SensorFit fit;
  fit.bias = *std::move(bias);
  fit.warnings = fit.bias.warnings;
  if (!rows.scale[s]) return fit;
  auto scale = fit_constant(*rows.scale[s], {name + " scale", "ppm", 1.0}, rows.validity[s],
                            rows.validity[s].scale_per_k, rows.scale_type_b[s]);
  if (!scale) return base::forward_error(scale);
  fit.scale = *std::move(scale);
  return fit;
}

// What of a model leaves the laboratory.

UncertaintyTable uncertainty_table(const CurveFit& fit, bool with_prediction) {
  UncertaintyTable table;
  table.one_run = fit.runs.size() == 1;
  for (const CurvePoint& point : fit.points) {
    table.temp_c.push_back(point.temp_c);
    table.ci95.push_back(point.ci95);
    if (with_prediction && point.pi95) table.pi95.push_back(*point.pi95);
  }
  return table;
}

std::array<Vector3, 3> coupling_values(const Coupling& coupling) {
  std::array<Vector3, 3> values{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) values[i][j] = coupling[i][j].value;
  }
  return values;
}

double standard_uncertainty(const StatedValue& stated) {
  return std::hypot(stated.standard_error, stated.type_b.value_or(0.0));
}

CouplingUncertainty coupling_uncertainty(const Coupling& coupling) {
  CouplingUncertainty uncertainty;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (i == j) continue;
      uncertainty.standard[i][j] = standard_uncertainty(coupling[i][j]);
      uncertainty.readings_only = uncertainty.readings_only || !coupling[i][j].type_b;
    }
  }
  return uncertainty;
}

std::optional<EvenOrderTerm> even_order_term(const std::optional<StatedValue>& stated) {
  if (!stated) return std::nullopt;
  return EvenOrderTerm{stated->value, standard_uncertainty(*stated), !stated->type_b};
}

/// Terms that concern the mounting or the lab's procedure and not the unit.
bool of_the_lab(const ModelTerm& term) { return term.name == "fixture_tilt" || term.name == "earth_rate"; }

/// Gyros that the term does not act on keep what the rows say of how well that is known.
void add_g_sensitivity(const ModelTerm& term, const std::optional<Coupling>& rows, Calibration& calibration) {
  constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  calibration.g_sensitivity.emplace();
  calibration.g_sensitivity_uncertainty.emplace();
  calibration.g_sensitivity_uncertainty->readings_only = true;
  for (const Sensor gyro : kSensors) {
    if (!is_gyro(gyro)) continue;
    const TermPart* part = term.part_of(gyro);
    for (std::size_t j = 0; j < 3; ++j) {
      if (part == nullptr) {
        if (rows) {
          calibration.g_sensitivity_uncertainty->standard[axis_of(gyro)][j] =
              standard_uncertainty((*rows)[axis_of(gyro)][j]);
        }
        continue;
      }
      (*calibration.g_sensitivity)[axis_of(gyro)][j] = part->value(kAxes[j]).value_or(0.0);
      auto& standard = calibration.g_sensitivity_uncertainty->standard[axis_of(gyro)];
      if (part->covariance.size() == 9) standard[j] = std::sqrt(part->covariance[4 * j]);
      // A term of the force along the gyro's own axis alone.
      if (part->covariance.size() == 1 && j == axis_of(gyro)) standard[j] = std::sqrt(part->covariance[0]);
    }
  }
}

/// The readings were freed of the term, so that what the rows still show is beside it.
void add_even_order(const ModelTerm& term, Calibration& calibration) {
  for (const TermPart& part : term.parts) {
    for (const Sensor sensor : part.sensors) {
      auto& total = calibration.even_order.at(axis_of(sensor));
      if (!total) total.emplace();
      total->value += part.value("even_order").value_or(0.0);
      if (!part.covariance.empty()) {
        // Both come from the same readings.
        total->standard_uncertainty = std::max(total->standard_uncertainty, std::sqrt(part.covariance.front()));
      }
    }
  }
}

void add_term(const ModelTerm& term, const std::optional<Coupling>& g_sensitivity, Calibration& calibration) {
  if (of_the_lab(term)) return;
  if (term.name == "g_sensitivity") return add_g_sensitivity(term, g_sensitivity, calibration);
  if (term.name == "scale_nonlinearity") return add_even_order(term, calibration);
  std::ranges::move(deployed_term(term), std::back_inserter(calibration.terms));
}

}  // namespace

base::Result<SensorFit> fit_sensor(const UnitRows& rows, Sensor sensor, const CurveFitOptions& options) {
  const auto& bias = rows.bias[index_of(sensor)];
  const std::string name(name_of(sensor));
  if (!bias) return base::bad_input("no run gives this sensor", name);
  if (is_of_one_temperature(*bias)) return constants_of(rows, sensor);
  const auto bump = bump_of(rows.terms, sensor);
  auto fitted = fit_curve(bump ? without_bump(*bias, *bump) : *bias, options,
                          {name, std::string(printed_unit(sensor)), printed_per_si(sensor)},
                          rows.bias_type_b[index_of(sensor)], rows.hysteresis[index_of(sensor)]);
  if (!fitted) return base::forward_error(fitted);
  SensorFit fit;
  fit.bias = std::move(*fitted);
  if (bump) add_bump(*bump, fit.bias);
  fit.warnings = fit.bias.warnings;
  if (rows.relative_accel && !is_gyro(sensor)) {
    fit.relative = true;
    make_relative(fit.bias);
  }
  const auto& scale = rows.scale[index_of(sensor)];
  if (scale && is_gyro(sensor) && distinct_temperatures(*scale) < kCurveTemperatures) {
    // Turns between positions show a gyro's scale where a power-on stays at one plateau, passes over the others do not.
    fit.warnings.push_back(
        {"scale_left_out", fmt::format("{}: its scale was measured at {} temperatures, a curve needs {}; "
                                       "the model has none",
                                       name, distinct_temperatures(*scale), kCurveTemperatures)});
  } else if (scale) {
    auto scale_fit = fit_curve(*scale, {}, {name + " scale", "ppm", 1.0}, rows.scale_type_b[index_of(sensor)]);
    if (!scale_fit) return base::forward_error(scale_fit);
    fit.scale = std::move(*scale_fit);
    warn_of_scale_range(sensor, *bias, fit);
    for (const Warning& warning : fit.scale->warnings) {
      // told of the bias, whose rows are of the same visits
      if (warning.code != "few_runs" && warning.code != "one_way") fit.warnings.push_back(warning);
    }
  }
  return fit;
}

UnitModel make_model(UnitRows rows, std::array<std::optional<SensorFit>, kSensorCount> sensors) {
  UnitModel model;
  model.unit = std::move(rows.unit);
  model.unit_type = std::move(rows.unit_type);
  model.epoch = rows.epoch;
  model.simulated = rows.simulated;
  model.gravity = std::move(rows.gravity);
  model.runs = std::move(rows.runs);
  model.references = std::move(rows.references);
  model.sensors = std::move(sensors);
  model.own_thermometer = rows.own_thermometer;
  model.accel_misalignment = rows.accel_misalignment;
  model.gyro_misalignment = rows.gyro_misalignment;
  model.g_sensitivity = rows.g_sensitivity;
  model.earth_removed = rows.earth_removed;
  model.even_order = rows.even_order;
  model.level = std::move(rows.level);
  model.terms = std::move(rows.terms);
  model.warnings = std::move(rows.warnings);
  return model;
}

Calibration make_calibration(const UnitModel& model) {
  Calibration calibration;
  calibration.unit = model.unit;
  calibration.unit_type = model.unit_type;
  calibration.epoch = model.epoch;
  calibration.model_version = model.version;
  calibration.created_utc_s = model.created_utc_s;
  calibration.simulated = model.simulated;
  calibration.gravity_mps2 = model.gravity.mps2;
  calibration.gravity_assumed = model.gravity.assumed;
  calibration.references = model.references;
  for (const RunReference& run : model.runs) calibration.run_hashes.push_back(run.content_sha256);
  for (const Sensor sensor : kSensors) {
    const auto& fit = model.sensors[index_of(sensor)];
    if (!fit) continue;
    SensorCalibration out;
    out.sensor = sensor;
    out.own_thermometer = model.own_thermometer[index_of(sensor)];
    out.temp_min_c = fit->bias.temp_min_c;
    out.temp_max_c = fit->bias.temp_max_c;
    out.model = name_of(fit->bias.deployed);
    if (fit->bias.deployed != Family::constant && bump_of(model.terms, sensor)) out.model += "+narrow_bump";
    out.bias = fit->bias.curve;
    out.bias_uncertainty = uncertainty_table(fit->bias, true);
    if (!fit->bias.one_way.ranges.empty()) out.one_way = fit->bias.one_way;
    if (fit->scale) {
      out.scale_ppm = fit->scale->curve;
      out.scale_uncertainty = uncertainty_table(*fit->scale, false);
    }
    calibration.sensors.push_back(std::move(out));
  }
  if (model.accel_misalignment) {
    calibration.accel_misalignment = coupling_values(*model.accel_misalignment);
    calibration.misalignment_uncertainty = coupling_uncertainty(*model.accel_misalignment);
  }
  if (model.gyro_misalignment) {
    calibration.gyro_misalignment = coupling_values(*model.gyro_misalignment);
    calibration.gyro_misalignment_uncertainty = coupling_uncertainty(*model.gyro_misalignment);
  }
  std::transform(model.even_order.begin(), model.even_order.end(), calibration.even_order.begin(), even_order_term);
  for (const ModelTerm& term : model.terms) add_term(term, model.g_sensitivity, calibration);
  return calibration;
}

}  // namespace soak::calib
