// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "calib/runtime/soak_runtime.h"
#include "station/calibration_reader.h"
#include "station/commands/calibration_commands.h"
#include "station/commands/waiver_note.h"
#include "station/waiver.h"

namespace soak::station {
namespace {

/// What the runtime says of one quantity of one sensor; nothing where the file has none.
struct Reading {
  std::optional<double> value;
  bool in_range = true;
};

Reading read(soak_status (*query)(const soak_cal*, int, float, float*), const soak_cal& calibration,
             calib::Sensor sensor, double temp_c) {
  float value = 0.0F;
  const soak_status status =
      query(&calibration, static_cast<int>(calib::index_of(sensor)), static_cast<float>(temp_c), &value);
  if (status != SOAK_OK && status != SOAK_CLAMPED) return {};
  return {value, status == SOAK_OK};
}

nlohmann::json evaluate_at(const soak_cal& calibration, double temp_c) {
  nlohmann::json bias = nlohmann::json::object();
  nlohmann::json scale = nlohmann::json::object();
  bool in_range = true;
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::string name(calib::name_of(sensor));
    const Reading reading = read(soak_bias, calibration, sensor, temp_c);
    if (!reading.value) continue;
    in_range = in_range && reading.in_range;
    bias[name] = *reading.value * calib::printed_per_si(sensor);
    scale[name] = number_or_null(read(soak_scale_ppm, calibration, sensor, temp_c).value);
  }
  return {{"temp_c", temp_c}, {"in_range", in_range}, {"bias", std::move(bias)}, {"scale_ppm", std::move(scale)}};
}

std::string describe(const nlohmann::json& points) {
  std::vector<std::vector<std::string>> table = {{"temp °C", "in range"}};
  for (const auto& [name, value] : points.front()["bias"].items()) {
    table.front().push_back(fmt::format("{} {}", name, name.starts_with("gyro") ? "deg/s" : "m/s2"));
    if (!points.front()["scale_ppm"][name].is_null()) table.front().push_back(name + " scale ppm");
  }
  for (const auto& point : points) {
    std::vector<std::string> row = {fmt::format("{:g}", point["temp_c"].get<double>()),
                                    point["in_range"].get<bool>() ? "yes" : "NO, clamped"};
    for (const auto& [name, value] : point["bias"].items()) {
      row.push_back(fmt::format("{:.6f}", value.get<double>()));
      const auto& scale = point["scale_ppm"][name];
      if (!scale.is_null()) row.push_back(fmt::format("{:.1f}", scale.get<double>()));
    }
    table.push_back(std::move(row));
  }
  return text_table(table);
}

}  // namespace

base::Status run_eval(const EvalCommand& command, Output& output) {
  const auto loaded = read_calibration(command.file);
  if (!loaded) return base::forward_error(loaded);
  soak_cal runtime;
  if (const soak_status status = soak_load(&runtime, loaded->bytes.data(), loaded->bytes.size()); status != SOAK_OK) {
    return base::corrupt(fmt::format("the deployment runtime refuses the file (status {})", static_cast<int>(status)),
                         command.file);
  }
  note_waivers(loaded->calibration.references, output);
  nlohmann::json points = nlohmann::json::array();
  for (const double temp_c : command.temps_c) points.push_back(evaluate_at(runtime, temp_c));
  if (output.json()) {
    nlohmann::json warnings = nlohmann::json::array();
    for (const calib::Warning& warning : waiver_warnings(loaded->calibration.references)) {
      warnings.push_back({{"code", warning.code}, {"text", warning.text}});
    }
    return output.print_json({{"unit", loaded->calibration.unit},
                              {"model", loaded->calibration.model_version},
                              {"points", std::move(points)},
                              {"warnings", std::move(warnings)}});
  }
  output.print(fmt::format("unit {}, model {}{}\n{}", loaded->calibration.unit, loaded->calibration.model_version,
                           loaded->calibration.simulated ? " (SIMULATED)" : "", describe(points)));
  return {};
}

}  // namespace soak::station
