// SPDX-License-Identifier: Apache-2.0
#include "calib/model/model_document.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "calib/model/document_parts.h"

namespace soak::calib {
namespace {

using nlohmann::json;

constexpr double kRoom_c = 25.0;

json number_json(const std::optional<double>& value, double factor = 1.0) {
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
    json entry = {{"held_out", check.fold}};
    for (std::size_t k = 0; k < kFamilyCount; ++k)
      entry[std::string(kFamilyNames[k])] = number_json(check.rmse[k], factor);
    list.push_back(std::move(entry));
  }
  return list;
}

json baselines_json(const CurveFit& fit, double factor) {
  json list = json::object();
  for (std::size_t k = 1; k < kFamilyCount; ++k) {
    const auto& error = fit.cross_validation[k];
    list[std::string(kFamilyNames[k])] = {{"rmse_abs", error ? number_json(error->rmse_abs, factor) : json()},
                                          {"rmse_shape", error ? number_json(error->rmse_shape, factor) : json()}};
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

/// Whether the scale error was measured at a temperature, and not only at others.
bool scale_measured(const SensorFit& fit, double temp_c) {
  return fit.scale && temp_c >= fit.scale->temp_min_c && temp_c <= fit.scale->temp_max_c;
}

json points_json(const SensorFit& fit, double factor) {
  json list = json::array();
  for (const CurvePoint& point : fit.bias.points) {
    const bool scale = scale_measured(fit, point.temp_c);
    list.push_back({{"temp_c", point.temp_c},
                    {"bias", point.value * factor},
                    {"ci95", point.ci95 * factor},
                    {"pi95", number_json(point.pi95, factor)},
                    {"scale_ppm", scale ? json(evaluate(fit.scale->curve, point.temp_c)) : json()},
                    {"scale_ci95_ppm", scale ? json(ci95_at(*fit.scale, point.temp_c)) : json()}});
  }
  return list;
}

/// Largest of the uncertainties at the points, and that at the point nearest to 25 °C; null where not stated.
json spread_json(const CurveFit& fit, const std::vector<double>& u, double factor) {
  if (u.empty()) return {{"max", nullptr}, {"at_25c", nullptr}};
  const auto nearest = std::ranges::min_element(
      fit.points, {}, [](const CurvePoint& point) { return std::abs(point.temp_c - kRoom_c); });
  return {{"max", factor * *std::ranges::max_element(u)},
          {"at_25c", factor * u[static_cast<std::size_t>(nearest - fit.points.begin())]}};
}

json budget_json(const CurveFit& fit, double factor) {
  json list = json::array();
  for (const Contribution& part : fit.budget) {
    list.push_back({{"name", part.name},
                    {"type", std::string(1, part.type)},
                    {"degrees_of_freedom", number_json(part.degrees_of_freedom)},
                    {"stated", part.stated()},
                    {"curve", spread_json(fit, part.u, factor)},
                    {"fresh_power_on", spread_json(fit, part.u_fresh, factor)},
                    {"basis", part.basis}});
  }
  return list;
}

/// Heating against cooling.
json sweeps_json(const CurveFit& fit, double factor) {
  if (!fit.sweeps) return {};
  return {{"largest", fit.sweeps->largest * factor},
          {"at_temp_c", fit.sweeps->at_temp_c},
          {"noise", fit.sweeps->noise * factor},
          {"half_rms", fit.sweeps->half_sigma * factor},
          {"p", fit.sweeps->p_value}};
}

/// Temperatures that no run visited both ways.
json one_way_json(const CurveFit& fit, double factor) {
  if (fit.one_way.ranges.empty()) return {};
  json ranges = json::array();
  for (const OneWayRange& range : fit.one_way.ranges) {
    ranges.push_back({{"low_c", range.low_c}, {"high_c", range.high_c}, {"sweep", name_of(range.sweep)}});
  }
  const bool known = fit.one_way.known.source != HysteresisSource::none;
  return {{"ranges", std::move(ranges)},
          {"half_gap", known ? json(fit.one_way.known.half_gap * factor) : json()},
          {"source", name_of(fit.one_way.known.source)}};
}

json fitted_sensor_json(Sensor sensor, const SensorFit& fit, bool own_thermometer) {
  const double factor = printed_per_si(sensor);
  const CurveFit& bias = fit.bias;
  const auto& error = bias.cross_validation[static_cast<std::size_t>(Family::anfis)];
  return {{"rules", bias.rules},
          {"order", bias.order},
          {"membership", bias.membership.empty() ? json() : json(bias.membership)},
          {"training", bias.training},
          {"train_rmse", bias.train_rmse * factor},
          {"check_rmse", error ? number_json(error->rmse_abs, factor) : json()},
          {"check_rmse_shape", error ? number_json(error->rmse_shape, factor) : json()},
          {"run_to_run_sigma", number_json(bias.run_to_run_sigma, factor)},
          {"lack_of_fit_sigma", bias.lack_of_fit_sigma * factor},
          {"sweeps", sweeps_json(bias, factor)},
          {"one_way", one_way_json(bias, factor)},
          {"relative", fit.relative},
          {"runs", bias.runs},
          {"holdout", bias.holdout},
          {"checks", checks_json(bias, factor)},
          {"thermometer", own_thermometer ? "own" : "unit"},
          {"temp_min_c", bias.temp_min_c},
          {"temp_max_c", bias.temp_max_c},
          {"curve", points_json(fit, factor)},
          {"uncertainty", budget_json(bias, factor)},
          {"scale_uncertainty", fit.scale ? budget_json(*fit.scale, 1.0) : json()},
          {"baselines", baselines_json(bias, factor)},
          {"deployed", name_of(bias.deployed)},
          {"scale_deployed", fit.scale ? json(name_of(fit.scale->deployed)) : json()},
          {"warnings", warnings_json(fit.warnings)}};
}

/// One member of the stated values of a matrix, row by row.
template <class Member>
json matrix_json(const Coupling& coupling, double factor, Member member) {
  json matrix = json::array();
  for (const auto& row : coupling) {
    json list = json::array();
    for (const StatedValue& entry : row) list.push_back(number_json(std::invoke(member, entry), factor));
    matrix.push_back(std::move(list));
  }
  return matrix;
}

json coupling_json(const std::optional<Coupling>& coupling, double factor) {
  if (!coupling) return {};
  return {{"value", matrix_json(*coupling, factor, &StatedValue::value)},
          {"standard_error", matrix_json(*coupling, factor, &StatedValue::standard_error)},
          {"type_b", matrix_json(*coupling, factor, &StatedValue::type_b)},
          {"ci95", matrix_json(*coupling, factor, &StatedValue::ci95)}};
}

json stated_json(const StatedValue& value, double factor) {
  return {{"value", value.value * factor},
          {"standard_error", value.standard_error * factor},
          {"type_b", number_json(value.type_b, factor)},
          {"ci95", value.ci95 * factor}};
}

json even_order_json(const std::array<std::optional<StatedValue>, 3>& terms) {
  json list = json::array();
  for (const auto& term : terms) {
    list.push_back(term ? stated_json(*term, base::kStandardGravity_mps2) : json());
  }
  return list;
}

json level_json(const LevelStatement& level) {
  const auto& known = level.to_north_east;
  return {{"north_rad", known ? stated_json((*known)[0], 1.0) : json()},
          {"east_rad", known ? stated_json((*known)[1], 1.0) : json()},
          {"reason", known ? json() : json(level.reason)}};
}

}  // namespace

json fit_json(const UnitModel& model) {
  json sensors = json::object();
  for (const Sensor sensor : kSensors) {
    const auto& fit = model.sensors[index_of(sensor)];
    if (!fit) continue;
    sensors[std::string(name_of(sensor))] = fitted_sensor_json(sensor, *fit, model.own_thermometer[index_of(sensor)]);
  }
  constexpr double kDegPerSecPerG = base::kDegPerRad * base::kStandardGravity_mps2;
  return {{"unit", model.unit},
          {"model", model.version},
          {"epoch", model.epoch},
          {"simulated", model.simulated},
          {"gravity_mps2", model.gravity.mps2},
          {"gravity", model.gravity.assumed ? "assumed" : "known"},
          {"references", references_json(model.references)},
          {"sensors", std::move(sensors)},
          {"accel_misalignment_rad", coupling_json(model.accel_misalignment, 1.0)},
          {"gyro_misalignment_rad", coupling_json(model.gyro_misalignment, 1.0)},
          {"g_sensitivity_dps_per_g", coupling_json(model.g_sensitivity, kDegPerSecPerG)},
          {"earth_rate_subtracted", name_of(model.earth_removed)},
          {"accel_even_order_g_per_g2", even_order_json(model.even_order)},
          {"level_error", level_json(model.level)},
          {"terms", terms_json(model.terms)},
          {"warnings", warnings_json(model.warnings)}};
}

}  // namespace soak::calib
