// SPDX-License-Identifier: Apache-2.0
#include "calib/fit_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace soak::calib {
namespace {

using nlohmann::json;

json number(const std::optional<double>& value, double factor = 1.0) {
  return value && std::isfinite(*value) ? json(*value * factor) : json();
}

json warnings_json(const std::vector<Warning>& warnings) {
  json list = json::array();
  for (const Warning& warning : warnings) list.push_back({{"code", warning.code}, {"text", warning.text}});
  return list;
}

json checks_json(const CurveFit& fit, double factor) {
  json list = json::array();
  for (const FoldErrors& check : fit.checks) {
    json entry = {{"held_out", check.held_out}};
    for (std::size_t k = 0; k < kFamilyCount; ++k) entry[std::string(kFamilyNames[k])] = number(check.rmse[k], factor);
    list.push_back(std::move(entry));
  }
  return list;
}

json baselines_json(const CurveFit& fit, double factor) {
  json list = json::object();
  for (std::size_t k = 1; k < kFamilyCount; ++k) {
    const auto& error = fit.held_out[k];
    list[std::string(kFamilyNames[k])] = {{"rmse_abs", error ? number(error->rmse_abs, factor) : json()},
                                          {"rmse_shape", error ? number(error->rmse_shape, factor) : json()}};
  }
  return list;
}

/// ci95 of a curve between its points.
double ci95_at(const CurveFit& fit, double temp_c) {
  const auto& points = fit.points;
  const auto above = std::lower_bound(points.begin(), points.end(), temp_c,
                                      [](const CurvePoint& point, double t) { return point.temp_c < t; });
  if (above == points.begin()) return points.front().ci95;
  if (above == points.end()) return points.back().ci95;
  const CurvePoint& below = *(above - 1);
  return std::lerp(below.ci95, above->ci95, (temp_c - below.temp_c) / (above->temp_c - below.temp_c));
}

json curve_json(const SensorFit& fit, double factor) {
  json list = json::array();
  for (const CurvePoint& point : fit.bias.points) {
    list.push_back({{"temp_c", point.temp_c},
                    {"bias", point.value * factor},
                    {"ci95", point.ci95 * factor},
                    {"pi95", number(point.pi95, factor)},
                    {"scale_ppm", fit.scale ? json(evaluate(fit.scale->curve, point.temp_c)) : json()},
                    {"scale_ci95_ppm", fit.scale ? json(ci95_at(*fit.scale, point.temp_c)) : json()}});
  }
  return list;
}

json sensor_json(Sensor sensor, const SensorFit& fit) {
  const double factor = printed_per_si(sensor);
  const CurveFit& bias = fit.bias;
  const auto& error = bias.held_out[static_cast<std::size_t>(Family::anfis)];
  return {{"rules", bias.rules},
          {"order", bias.order},
          {"membership", bias.membership.empty() ? json() : json(bias.membership)},
          {"training", bias.training},
          {"train_rmse", bias.train_rmse * factor},
          {"check_rmse", error ? number(error->rmse_abs, factor) : json()},
          {"check_rmse_shape", error ? number(error->rmse_shape, factor) : json()},
          {"run_to_run_sigma", number(bias.run_to_run_sigma, factor)},
          {"lack_of_fit_sigma", bias.lack_of_fit_sigma * factor},
          {"relative", fit.relative},
          {"runs", bias.runs},
          {"holdout", bias.holdout},
          {"checks", checks_json(bias, factor)},
          {"temp_min_c", bias.temp_min_c},
          {"temp_max_c", bias.temp_max_c},
          {"curve", curve_json(fit, factor)},
          {"baselines", baselines_json(bias, factor)},
          {"deployed", name_of(bias.deployed)},
          {"scale_deployed", fit.scale ? json(name_of(fit.scale->deployed)) : json()},
          {"warnings", warnings_json(fit.warnings)}};
}

json coupling_json(const std::optional<Coupling>& coupling, double factor) {
  if (!coupling) return {};
  json value = json::array();
  json error = json::array();
  for (std::size_t i = 0; i < 3; ++i) {
    json row = json::array();
    json row_error = json::array();
    for (std::size_t j = 0; j < 3; ++j) {
      row.push_back(coupling->value[i][j] * factor);
      row_error.push_back(coupling->standard_error[i][j] * factor);
    }
    value.push_back(std::move(row));
    error.push_back(std::move(row_error));
  }
  return {{"value", std::move(value)}, {"standard_error", std::move(error)}};
}

}  // namespace

json fit_json(const UnitModel& model) {
  json sensors = json::object();
  for (const Sensor sensor : kSensors) {
    const auto& fit = model.sensors[index_of(sensor)];
    if (fit) sensors[std::string(name_of(sensor))] = sensor_json(sensor, *fit);
  }
  constexpr double kDegPerSecPerG = base::kDegPerRad * base::kStandardGravity_mps2;
  return {{"unit", model.unit},
          {"model", model.version},
          {"epoch", model.epoch},
          {"simulated", model.simulated},
          {"gravity_mps2", model.gravity.mps2},
          {"gravity", model.gravity.assumed ? "assumed" : "known"},
          {"sensors", std::move(sensors)},
          {"accel_misalignment_rad", coupling_json(model.accel_misalignment, 1.0)},
          {"g_sensitivity_dps_per_g", coupling_json(model.g_sensitivity, kDegPerSecPerG)},
          {"warnings", warnings_json(model.warnings)}};
}

}  // namespace soak::calib
