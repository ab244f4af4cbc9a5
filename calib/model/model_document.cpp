// SPDX-License-Identifier: Apache-2.0
#include "calib/model/model_document.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "anfis/persist/model_json.h"
#include "calib/model/document_parts.h"

namespace soak::calib {

// Members as the document names them.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SplineCurve, knots_c, coefficients)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TableCurve, first_c, step_c, values)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CouplingUncertainty, standard, readings_only)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(EvenOrderTerm, value, standard_uncertainty, readings_only)

namespace {

using nlohmann::json;

json table_to_json(const UncertaintyTable& table) {
  json document = {{"temp_c", table.temp_c}, {"ci95", table.ci95}, {"pi95", table.pi95}};
  if (table.one_run) document["one_run"] = true;
  return document;
}

UncertaintyTable table_from_json(const json& document) {
  UncertaintyTable table;
  document.at("temp_c").get_to(table.temp_c);
  document.at("ci95").get_to(table.ci95);
  document.at("pi95").get_to(table.pi95);
  table.one_run = document.value("one_run", false);
  return table;
}

json one_way_to_json(const OneWay& one_way) {
  json ranges = json::array();
  for (const OneWayRange& range : one_way.ranges) {
    ranges.push_back({{"low_c", range.low_c}, {"high_c", range.high_c}, {"sweep", name_of(range.sweep)}});
  }
  return {
      {"ranges", std::move(ranges)}, {"half_gap", one_way.known.half_gap}, {"source", name_of(one_way.known.source)}};
}

base::Result<OneWay> one_way_from_json(const json& document) {
  OneWay one_way;
  for (const json& entry : document.at("ranges")) {
    OneWayRange range{entry.at("low_c").get<double>(), entry.at("high_c").get<double>(),
                      sweep_named(entry.at("sweep").get<std::string>())};
    if (range.sweep == Sweep::unknown) return base::corrupt("a one-way range without its way", "model document");
    one_way.ranges.push_back(range);
  }
  document.at("half_gap").get_to(one_way.known.half_gap);
  const auto source = document.at("source").get<std::string>();
  for (const HysteresisSource known : {HysteresisSource::none, HysteresisSource::type, HysteresisSource::fleet}) {
    if (name_of(known) != source) continue;
    one_way.known.source = known;
    return one_way;
  }
  return base::corrupt(fmt::format("unknown source of hysteresis '{}'", source), "model document");
}

/// 2: models as anfis/persist/model_json.h writes them in its version 2; everything else as in 1. 3: with misalignment
/// of the gyros, which a program that knows it not would leave out of the file; all other documents are written as 2.
constexpr int kModelFormat = 3;
constexpr int kWithoutGyroMisalignment = 2;

base::Result<json> curve_to_json(const Curve& curve) {
  if (const auto* model = std::get_if<anfis::Model>(&curve)) {
    auto document = anfis::model_to_json(*model);
    if (!document) return base::forward_error(document);
    return json{{"kind", "fis"}, {"model", *std::move(document)}};
  }
  json document;
  if (const auto* spline = std::get_if<SplineCurve>(&curve)) {
    document = *spline;
    document["kind"] = "spline";
  } else {
    document = std::get<TableCurve>(curve);
    document["kind"] = "table";
  }
  return document;
}

/// Throws json::exception where a member is missing; calibration_of() catches it.
base::Result<Curve> curve_from_json(const json& document) {
  const auto kind = document.at("kind").get<std::string>();
  if (kind == "fis") {
    auto model = anfis::model_from_json(document.at("model"));
    if (!model) return base::forward_error(model);
    if (model->inputs.size() != 1) {
      return base::corrupt(
          fmt::format("a curve over temperature has one input, this model has {}", model->inputs.size()),
          "model document");
    }
    return Curve(*std::move(model));
  }
  if (kind == "spline") return Curve(document.get<SplineCurve>());
  if (kind == "table") return Curve(document.get<TableCurve>());
  return base::corrupt(fmt::format("unknown kind of curve '{}'", kind), "model document");
}

base::Result<json> sensor_to_json(const SensorCalibration& sensor) {
  auto bias = curve_to_json(sensor.bias);
  if (!bias) return base::forward_error(bias);
  json document = {{"sensor", name_of(sensor.sensor)}, {"temp_min_c", sensor.temp_min_c},
                   {"temp_max_c", sensor.temp_max_c},  {"model", sensor.model},
                   {"bias", *std::move(bias)},         {"bias_uncertainty", table_to_json(sensor.bias_uncertainty)}};
  if (sensor.scale_ppm) {
    auto scale = curve_to_json(*sensor.scale_ppm);
    if (!scale) return base::forward_error(scale);
    document["scale_ppm"] = *std::move(scale);
  }
  if (sensor.scale_uncertainty) document["scale_uncertainty"] = table_to_json(*sensor.scale_uncertainty);
  if (sensor.one_way) document["one_way"] = one_way_to_json(*sensor.one_way);
  if (sensor.own_thermometer) document["own_thermometer"] = true;
  return document;
}

base::Result<SensorCalibration> sensor_from_json(const json& document) {
  const auto name = document.at("sensor").get<std::string>();
  const auto sensor = sensor_named(name);
  if (!sensor) return base::corrupt(fmt::format("unknown sensor '{}'", name), "model document");
  SensorCalibration calibration;
  calibration.sensor = *sensor;
  calibration.own_thermometer = document.value("own_thermometer", false);
  document.at("temp_min_c").get_to(calibration.temp_min_c);
  document.at("temp_max_c").get_to(calibration.temp_max_c);
  document.at("model").get_to(calibration.model);
  auto bias = curve_from_json(document.at("bias"));
  if (!bias) return base::forward_error(bias);
  calibration.bias = *std::move(bias);
  calibration.bias_uncertainty = table_from_json(document.at("bias_uncertainty"));
  if (document.contains("one_way")) {
    auto one_way = one_way_from_json(document["one_way"]);
    if (!one_way) return base::forward_error(one_way);
    calibration.one_way = *std::move(one_way);
  }
  if (document.contains("scale_ppm")) {
    auto scale = curve_from_json(document["scale_ppm"]);
    if (!scale) return base::forward_error(scale);
    calibration.scale_ppm = *std::move(scale);
  }
  if (document.contains("scale_uncertainty")) {
    calibration.scale_uncertainty = table_from_json(document["scale_uncertainty"]);
  }
  return calibration;
}

/// What is stated of the couplings, into the document and back; documents of older programs have none of it.
void couplings_to_json(const Calibration& calibration, json& document) {
  if (const auto& stated = calibration.misalignment_uncertainty) document["misalignment_uncertainty"] = *stated;
  if (const auto& stated = calibration.gyro_misalignment_uncertainty) {
    document["gyro_misalignment_uncertainty"] = *stated;
  }
  if (const auto& stated = calibration.g_sensitivity_uncertainty) document["g_sensitivity_uncertainty"] = *stated;
  json terms = json::object();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (const auto& term = calibration.even_order[axis]) terms[std::string(name_of(kSensors[3 + axis]))] = *term;
  }
  if (!terms.empty()) document["even_order"] = std::move(terms);
}

void couplings_from_json(const json& document, Calibration& calibration) {
  if (document.contains("misalignment_uncertainty")) {
    calibration.misalignment_uncertainty = document["misalignment_uncertainty"].get<CouplingUncertainty>();
  }
  if (document.contains("gyro_misalignment_uncertainty")) {
    calibration.gyro_misalignment_uncertainty = document["gyro_misalignment_uncertainty"].get<CouplingUncertainty>();
  }
  if (document.contains("g_sensitivity_uncertainty")) {
    calibration.g_sensitivity_uncertainty = document["g_sensitivity_uncertainty"].get<CouplingUncertainty>();
  }
  const json terms = document.value("even_order", json::object());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto found = terms.find(std::string(name_of(kSensors[3 + axis])));
    if (found != terms.end()) calibration.even_order[axis] = found->get<EvenOrderTerm>();
  }
}

/// Accepted terms as the file carries them.
void accepted_to_json(const Calibration& calibration, json& document) {
  json list = json::array();
  for (const AcceptedTerm& term : calibration.terms) {
    json sensors = json::array();
    for (const Sensor sensor : term.sensors) sensors.push_back(name_of(sensor));
    list.push_back({{"name", term.name},
                    {"lab_only", term.lab_only},
                    {"sensors", std::move(sensors)},
                    {"parameters", term.parameters}});
  }
  if (!list.empty()) document["terms"] = std::move(list);
}

base::Status accepted_from_json(const json& document, Calibration& calibration) {
  const json list = document.value("terms", json::array());
  for (const json& entry : list) {
    AcceptedTerm term;
    term.name = entry.at("name").get<std::string>();
    term.lab_only = entry.at("lab_only").get<bool>();
    term.parameters = entry.at("parameters").get<std::vector<std::pair<std::string, double>>>();
    for (const json& name : entry.at("sensors")) {
      const auto sensor = sensor_named(name.get<std::string>());
      if (!sensor) {
        return base::corrupt(fmt::format("unknown sensor '{}' of a term", name.get<std::string>()), "model document");
      }
      term.sensors.push_back(*sensor);
    }
    calibration.terms.push_back(std::move(term));
  }
  return {};
}

base::Result<json> calibration_to_json(const Calibration& calibration) {
  json sensors = json::array();
  for (const SensorCalibration& sensor : calibration.sensors) {
    auto entry = sensor_to_json(sensor);
    if (!entry) return base::forward_error(entry);
    sensors.push_back(*std::move(entry));
  }
  json document = {{"unit", calibration.unit},
                   {"unit_type", calibration.unit_type},
                   {"epoch", calibration.epoch},
                   {"model_version", calibration.model_version},
                   {"created_utc_s", calibration.created_utc_s},
                   {"simulated", calibration.simulated},
                   {"gravity_mps2", calibration.gravity_mps2},
                   {"gravity_assumed", calibration.gravity_assumed},
                   {"run_hashes", calibration.run_hashes},
                   {"sensors", std::move(sensors)}};
  if (calibration.accel_misalignment) document["accel_misalignment"] = *calibration.accel_misalignment;
  if (calibration.gyro_misalignment) document["gyro_misalignment"] = *calibration.gyro_misalignment;
  if (calibration.g_sensitivity) document["g_sensitivity"] = *calibration.g_sensitivity;
  accepted_to_json(calibration, document);
  couplings_to_json(calibration, document);
  if (!calibration.references.empty()) document["references"] = stored_references(calibration.references);
  return document;
}

base::Result<Calibration> calibration_from_json(const json& document) {
  Calibration calibration;
  document.at("unit").get_to(calibration.unit);
  document.at("unit_type").get_to(calibration.unit_type);
  document.at("epoch").get_to(calibration.epoch);
  document.at("model_version").get_to(calibration.model_version);
  document.at("created_utc_s").get_to(calibration.created_utc_s);
  document.at("simulated").get_to(calibration.simulated);
  document.at("gravity_mps2").get_to(calibration.gravity_mps2);
  document.at("gravity_assumed").get_to(calibration.gravity_assumed);
  document.at("run_hashes").get_to(calibration.run_hashes);
  for (const json& entry : document.at("sensors")) {
    auto sensor = sensor_from_json(entry);
    if (!sensor) return base::forward_error(sensor);
    calibration.sensors.push_back(*std::move(sensor));
  }
  if (document.contains("accel_misalignment")) {
    calibration.accel_misalignment = document["accel_misalignment"].get<std::array<Vector3, 3>>();
  }
  if (document.contains("gyro_misalignment")) {
    calibration.gyro_misalignment = document["gyro_misalignment"].get<std::array<Vector3, 3>>();
  }
  if (document.contains("g_sensitivity")) {
    calibration.g_sensitivity = document["g_sensitivity"].get<std::array<Vector3, 3>>();
  }
  couplings_from_json(document, calibration);
  if (auto accepted = accepted_from_json(document, calibration); !accepted) return base::forward_error(accepted);
  if (document.contains("references")) {
    auto references = references_of(document["references"]);
    if (!references) return base::forward_error(references);
    calibration.references = *std::move(references);
  }
  return calibration;
}

/// What `read` makes of a stored document; throws nothing.
template <class Read>
auto read_document(std::string_view text, Read read) -> decltype(read(json())) {
  try {
    const json document = json::parse(text);
    if (document.at("format") != "soak-model") return base::corrupt("not a model document", "station.db");
    const int version = document.at("format_version").get<int>();
    if (version > kModelFormat) {
      return base::bad_input(
          fmt::format("the model was stored in format {}; this program knows up to {}: use a newer soak", version,
                      kModelFormat),
          "station.db");
    }
    return read(document);
  } catch (const json::exception& error) {
    return base::corrupt(fmt::format("the stored model cannot be read: {}", error.what()), "station.db");
  }
}

}  // namespace

base::Result<std::string> model_document(const UnitModel& model) {
  auto calibration = calibration_to_json(make_calibration(model));
  if (!calibration) return base::forward_error(calibration);
  const json document = {{"format", "soak-model"},
                         {"format_version", model.gyro_misalignment ? kModelFormat : kWithoutGyroMisalignment},
                         {"options", {{"rules", model.options.rules ? json(*model.options.rules) : json()}}},
                         {"fit", fit_json(model)},
                         {"calibration", *std::move(calibration)},
                         {"terms", terms_json(model.terms)}};
  return document.dump();
}

base::Result<Calibration> calibration_of(std::string_view text) {
  return read_document(text, [](const json& document) { return calibration_from_json(document.at("calibration")); });
}

base::Result<CurveFitOptions> fit_options_of(std::string_view text) {
  return read_document(text, [](const json& document) -> base::Result<CurveFitOptions> {
    CurveFitOptions options;
    const json stored = document.value("options", json::object());
    if (stored.contains("rules") && !stored["rules"].is_null()) options.rules = stored["rules"].get<int>();
    return options;
  });
}

base::Result<std::vector<ModelTerm>> model_terms_of(std::string_view text) {
  return read_document(text, [](const json& document) { return terms_of(document.value("terms", json::array())); });
}

}  // namespace soak::calib
