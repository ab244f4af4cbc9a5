// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "anfis/model/one_input.h"
#include "base/text.h"
#include "calib/model/document_parts.h"

namespace soak::calib {
namespace {

using Json = nlohmann::ordered_json;

/// Parameters of a curve whose values are multiplied by `factor` for print.
Json parameters(const anfis::Model& model, double factor) {
  const anfis::Input& input = model.inputs[0];
  Json rules = Json::array();
  for (const anfis::CurveRule& rule : anfis::curve_rules(model)) {
    rules.push_back({{"width", rule.width},
                     {"slope", rule.slope},
                     {"centre", rule.centre},
                     {"gain", rule.gain},
                     {"offset", rule.offset}});
  }
  return {{"kind", "fis"},
          {"membership", anfis::name(anfis::curve_shape(model))},
          {"order", model.order},
          {"temp_min_c", input.min},
          {"temp_max_c", input.max},
          {"input_centre", input.scale.centre},
          {"input_half_range", input.scale.half_range},
          {"output_centre", factor * model.output.centre},
          {"output_half_range", factor * model.output.half_range},
          {"rules", std::move(rules)}};
}

Json parameters(const SplineCurve& spline, double factor) {
  Json coefficients = Json::array();
  for (const auto& piece : spline.coefficients) {
    coefficients.push_back({factor * piece[0], factor * piece[1], factor * piece[2], factor * piece[3]});
  }
  return {{"kind", "spline"}, {"knots_c", spline.knots_c}, {"coefficients", std::move(coefficients)}};
}

Json parameters(const TableCurve& table, double factor) {
  std::vector<double> values = table.values;
  for (double& value : values) value *= factor;
  return {{"kind", "table"}, {"first_c", table.first_c}, {"step_c", table.step_c}, {"values", std::move(values)}};
}

Json parameters(const Curve& curve, double factor) {
  return std::visit([&](const auto& kind) { return parameters(kind, factor); }, curve);
}

/// temp_min_c, every whole step of 1 °C above it, temp_max_c.
std::vector<double> print_temperatures(const SensorCalibration& sensor) {
  std::vector<double> temps;
  for (int i = 0; sensor.temp_min_c + i < sensor.temp_max_c; ++i) temps.push_back(sensor.temp_min_c + i);
  temps.push_back(sensor.temp_max_c);
  return temps;
}

Json dense_curve(const SensorCalibration& sensor, double factor) {
  Json points = Json::array();
  for (const double temp_c : print_temperatures(sensor)) {
    const auto scale_ppm = measured_scale_ppm(sensor, temp_c);
    points.push_back({{"temp_c", temp_c},
                      {"bias", factor * evaluate(sensor.bias, temp_c)},
                      {"scale_ppm", scale_ppm ? Json(*scale_ppm) : Json()}});
  }
  return points;
}

Json uncertainty(const UncertaintyTable& table, double factor) {
  Json points = Json::array();
  for (std::size_t i = 0; i < table.temp_c.size(); ++i) {
    points.push_back({{"temp_c", table.temp_c[i]},
                      {"ci95", factor * table.ci95[i]},
                      {"pi95", table.pi95.empty() ? Json() : Json(factor * table.pi95[i])}});
  }
  return points;
}

Json one_way(const std::optional<OneWay>& stated, double factor) {
  if (!stated) return {};
  Json ranges = Json::array();
  for (const OneWayRange& range : stated->ranges) {
    ranges.push_back({{"low_c", range.low_c}, {"high_c", range.high_c}, {"sweep", name_of(range.sweep)}});
  }
  const bool known = stated->known.source != HysteresisSource::none;
  return {{"ranges", std::move(ranges)},
          {"half_gap", known ? Json(factor * stated->known.half_gap) : Json()},
          {"source", name_of(stated->known.source)}};
}

Json sensor_document(const SensorCalibration& sensor) {
  const double factor = printed_per_si(sensor.sensor);
  return {{"unit", printed_unit(sensor.sensor)},
          {"model", sensor.model},
          {"thermometer", sensor.own_thermometer ? "own" : "unit"},
          {"temp_min_c", sensor.temp_min_c},
          {"temp_max_c", sensor.temp_max_c},
          {"curve", dense_curve(sensor, factor)},
          {"bias", parameters(sensor.bias, factor)},
          {"bias_uncertainty", uncertainty(sensor.bias_uncertainty, factor)},
          {"one_run", sensor.bias_uncertainty.one_run},
          {"one_way", one_way(sensor.one_way, factor)},
          {"scale_ppm", sensor.scale_ppm ? parameters(*sensor.scale_ppm, 1.0) : Json()},
          {"scale_uncertainty", sensor.scale_uncertainty ? uncertainty(*sensor.scale_uncertainty, 1.0) : Json()}};
}

Json matrix(const std::optional<std::array<Vector3, 3>>& rows, double factor) {
  if (!rows) return {};
  Json out = Json::array();
  for (const Vector3& row : *rows) out.push_back({factor * row[0], factor * row[1], factor * row[2]});
  return out;
}

Json coupling_uncertainty(const std::optional<CouplingUncertainty>& stated, double factor) {
  if (!stated) return {};
  return {{"standard_uncertainty", matrix(stated->standard, factor)}, {"readings_only", stated->readings_only}};
}

/// By accelerometer, null where the file does not state it.
Json even_order(const Calibration& calibration) {
  Json terms = Json::object();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& term = calibration.even_order[axis];
    terms[std::string(name_of(kSensors[3 + axis]))] = term ? Json{{"value", term->value},
                                                                  {"standard_uncertainty", term->standard_uncertainty},
                                                                  {"readings_only", term->readings_only}}
                                                           : Json();
  }
  return terms;
}

Json term_document(const AcceptedTerm& term) {
  Json sensors = Json::array();
  for (const Sensor sensor : term.sensors) sensors.push_back(name_of(sensor));
  Json numbers = Json::object();
  for (const auto& [name, value] : term.parameters) numbers[name] = value;
  return {{"name", term.name},
          {"lab_only", term.lab_only},
          {"sensors", std::move(sensors)},
          {"parameters", std::move(numbers)}};
}

/// Refuses models that parameters() cannot write.
base::Status check_model(const Curve& curve, const std::string& where) {
  const auto* model = std::get_if<anfis::Model>(&curve);
  if (model == nullptr) return {};
  base::Status status = anfis::validate(*model);
  if (status) status = anfis::validate_curve(*model);
  if (status) return {};
  return base::bad_input("the document cannot carry this fuzzy model: " + status.error().message,
                         where + '/' + status.error().where);
}

base::Status check_models(const Calibration& calibration) {
  for (const SensorCalibration& sensor : calibration.sensors) {
    const std::string place = "/sensors/" + std::string(name_of(sensor.sensor));
    if (auto status = check_model(sensor.bias, place + "/bias"); !status) return status;
    if (!sensor.scale_ppm) continue;
    if (auto status = check_model(*sensor.scale_ppm, place + "/scale_ppm"); !status) return status;
  }
  return {};
}

/// The place of the first number that JSON cannot carry ("/sensors/gyro_x/curve/3/bias"); empty if there is none.
std::string not_finite(const Json& node, const std::string& path) {
  if (node.is_number_float() && !std::isfinite(node.get<double>())) return path.empty() ? "/" : path;
  if (!node.is_structured()) return {};
  for (const auto& [key, value] : node.items()) {
    std::string inner = path;
    inner.append("/").append(key);
    std::string found = not_finite(value, inner);
    if (!found.empty()) return found;
  }
  return {};
}

}  // namespace

base::Result<std::string> export_json(const Calibration& calibration) {
  if (auto status = check_models(calibration); !status) return base::forward_error(status);
  Json sensors = Json::object();
  for (const SensorCalibration& sensor : calibration.sensors) {
    sensors[std::string(name_of(sensor.sensor))] = sensor_document(sensor);
  }
  Json terms = Json::array();
  for (const AcceptedTerm& term : calibration.terms) terms.push_back(term_document(term));
  const Json document = {
      {"format", "soak-calibration-1"},
      {"unit", calibration.unit},
      {"unit_type", calibration.unit_type},
      {"epoch", calibration.epoch},
      {"model", calibration.model_version},
      {"created_utc", base::utc_text(calibration.created_utc_s)},
      {"created_utc_s", calibration.created_utc_s},
      {"simulated", calibration.simulated},
      {"unreleased", calibration.unreleased},
      {"gravity_mps2", calibration.gravity_mps2},
      {"gravity", calibration.gravity_assumed ? "assumed" : "known"},
      {"references", references_json(calibration.references)},
      {"runs", calibration.run_hashes},
      {"sensors", std::move(sensors)},
      {"accel_misalignment", matrix(calibration.accel_misalignment, 1.0)},
      {"gyro_misalignment", matrix(calibration.gyro_misalignment, 1.0)},
      {"g_sensitivity_dps_per_mps2", matrix(calibration.g_sensitivity, base::kDegPerRad)},
      {"accel_misalignment_uncertainty", coupling_uncertainty(calibration.misalignment_uncertainty, 1.0)},
      {"gyro_misalignment_uncertainty", coupling_uncertainty(calibration.gyro_misalignment_uncertainty, 1.0)},
      {"g_sensitivity_uncertainty_dps_per_mps2",
       coupling_uncertainty(calibration.g_sensitivity_uncertainty, base::kDegPerRad)},
      {"accel_even_order_per_mps2", even_order(calibration)},
      {"terms", std::move(terms)}};
  const std::string where = not_finite(document, "");
  if (!where.empty()) return base::bad_input("the number is not finite, which JSON cannot carry", where);
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace soak::calib
