// SPDX-License-Identifier: Apache-2.0
#include "station/report/noise_limit.h"

#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

namespace soak::station {
namespace {

using nlohmann::json;

/// The coefficient N as a one-sided density; null where nothing could be fitted.
json density_of(const json& allan) {
  const json coefficients = allan.value("coefficients", json::object());
  if (!coefficients.contains("angle_random_walk")) return {};
  const json& found = coefficients["angle_random_walk"];
  const auto one_sided = [](const json& value) {
    return value.is_number() ? json(std::numbers::sqrt2 * value.get<double>()) : json();
  };
  return {{"value", found["found"] == true ? one_sided(found["value"]) : json()},
          {"ci95", {one_sided(found["ci95"][0]), one_sided(found["ci95"][1])}}};
}

std::string verdict_of(const json& density, std::optional<double> limit) {
  if (!limit) return "no_limit";
  if (density.is_null()) return "not_known";
  if (density["value"].is_number()) return density["value"] <= *limit ? "inside" : "outside";
  const json& most = density["ci95"][1];
  return most.is_number() && most <= *limit ? "inside" : "not_known";
}

}  // namespace

std::optional<double> noise_limit(const calib::UnitType& type, calib::Sensor sensor) {
  return calib::is_gyro(sensor) ? type.gyro_noise_max_dps_rthz : type.accel_noise_max_mps2_rthz;
}

json judged_noise(const json& allan, calib::Sensor sensor, std::optional<double> limit) {
  json density = density_of(allan);
  json judged = {{"unit", calib::is_gyro(sensor) ? "deg/s" : "m/s2"},
                 {"verdict", verdict_of(density, limit)},
                 {"limit", limit ? json(*limit) : json()},
                 {"density", std::move(density)}};
  for (const char* key : {"rate_hz", "samples", "reason"}) judged[key] = allan.value(key, json());
  for (const char* key : {"tau_s", "oadev", "ci95"}) judged[key] = allan.value(key, json::array());
  return judged;
}

}  // namespace soak::station
