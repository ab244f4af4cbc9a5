// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "calib/runtime/soak_runtime.h"
#include "station/commands/calibration_commands.h"
#include "station/commands/waiver_note.h"
#include "station/records/calibration_reader.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

using calib::Sensor;
using nlohmann::json;

/// Temperature of each sensor's thermometer; NaN: of its own, and not given.
using Temperatures = std::array<double, calib::kSensorCount>;

/// What is asked of a file, and the file.
struct Question {
  const EvalCommand& command;
  const calib::Calibration& calibration;
  const soak_cal& runtime;

  [[nodiscard]] bool own_thermometer(Sensor sensor) const {
    return soak_has_own_thermometer(&runtime, static_cast<int>(calib::index_of(sensor))) != 0;
  }

  [[nodiscard]] Temperatures at(double temp_c) const {
    Temperatures temps_c;
    for (const Sensor sensor : calib::kSensors) {
      const auto& given = command.own_temps_c[calib::index_of(sensor)];
      temps_c[calib::index_of(sensor)] =
          own_thermometer(sensor) ? given.value_or(std::numeric_limits<double>::quiet_NaN()) : temp_c;
    }
    return temps_c;
  }
};

/// What the runtime says of one quantity of one sensor; nothing where the file has none.
struct Reading {
  std::optional<double> value;
  bool in_range = true;
};

Reading read_bias(const soak_cal& runtime, Sensor sensor, double temp_c) {
  float value = 0.0F;
  const soak_status status =
      soak_bias(&runtime, static_cast<int>(calib::index_of(sensor)), static_cast<float>(temp_c), &value);
  if (status != SOAK_OK && status != SOAK_CLAMPED) return {};
  return {value, status == SOAK_OK};
}

/// Scale error at the temperature held in the valid range; in_range: it was measured there.
Reading read_scale(const soak_cal& runtime, Sensor sensor, double temp_c) {
  const int index = static_cast<int>(calib::index_of(sensor));
  float low_c = 0.0F;
  float high_c = 0.0F;
  float value = 0.0F;
  if (!std::isfinite(temp_c) || soak_temp_range(&runtime, index, &low_c, &high_c) != SOAK_OK) return {};
  const float held_c = std::clamp(static_cast<float>(temp_c), low_c, high_c);
  const soak_status status = soak_scale_ppm(&runtime, index, held_c, &value);
  if (status != SOAK_OK && status != SOAK_CLAMPED) return {};
  return {value, status == SOAK_OK};
}

std::string_view name_of(soak_status status) {
  return status == SOAK_OK ? "ok" : status == SOAK_CLAMPED ? "clamped" : status == SOAK_ABSENT ? "absent" : "invalid";
}

/// The sample as the runtime corrects it: where no temperature of its own thermometers is known, as firmware does that
/// has one temperature.
json corrected_at(const Question& question, double temp_c) {
  float raw[calib::kSensorCount];
  float out[calib::kSensorCount];
  float temps_c[calib::kSensorCount];
  std::uint32_t flags = 0;
  const Temperatures at = question.at(temp_c);
  for (const Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    raw[s] = static_cast<float>((*question.command.raw)[s] / calib::printed_per_si(sensor));
    temps_c[s] = static_cast<float>(at[s]);
  }
  const bool several = std::ranges::any_of(question.command.own_temps_c, [](const auto& t) { return t.has_value(); });
  const soak_status status = several ? soak_apply_temps(&question.runtime, temps_c, raw, out, &flags)
                                     : soak_apply(&question.runtime, static_cast<float>(temp_c), raw, out, &flags);
  json values = json::object();
  for (const Sensor sensor : calib::kSensors) {
    values[std::string(calib::name_of(sensor))] =
        static_cast<double>(out[calib::index_of(sensor)]) * calib::printed_per_si(sensor);
  }
  return {{"status", name_of(status)}, {"flags", flags}, {"out", std::move(values)}};
}

json evaluate_at(const Question& question, double temp_c) {
  const Temperatures temps_c = question.at(temp_c);
  json bias = json::object();
  json scale = json::object();
  bool in_range = true;
  for (const calib::SensorCalibration& stated : question.calibration.sensors) {
    const std::string name(calib::name_of(stated.sensor));
    const double at_c = temps_c[calib::index_of(stated.sensor)];
    const Reading reading = read_bias(question.runtime, stated.sensor, at_c);
    const Reading ppm = read_scale(question.runtime, stated.sensor, at_c);
    in_range = in_range && reading.in_range;
    bias[name] = reading.value ? json(*reading.value * calib::printed_per_si(stated.sensor)) : json();
    scale[name] = ppm.in_range ? number_or_null(ppm.value) : json();
  }
  return {{"temp_c", temp_c},
          {"in_range", in_range},
          {"bias", std::move(bias)},
          {"scale_ppm", std::move(scale)},
          {"corrected", question.command.raw ? corrected_at(question, temp_c) : json()}};
}

/// Sensors over thermometers that the command gives no temperature of.
std::optional<calib::Warning> thermometer_warning(const Question& question) {
  std::vector<std::string> names;
  std::vector<std::string> wanted;
  for (const Sensor sensor : calib::kSensors) {
    if (!question.own_thermometer(sensor) || question.command.own_temps_c[calib::index_of(sensor)]) continue;
    names.emplace_back(calib::name_of(sensor));
    wanted.push_back(names.back() + "=T");
  }
  if (names.empty()) return std::nullopt;
  return calib::Warning{
      "own_thermometer",
      fmt::format("{}: calibrated over a thermometer of its own, whose temperature --temp-c is not: no value; give "
                  "--own-temp-c {}",
                  fmt::join(names, ", "), fmt::join(wanted, ","))};
}

/// Where the scale factor of a sensor was not measured.
std::optional<calib::Warning> scale_warning(const Question& question, const calib::SensorCalibration& sensor) {
  std::vector<std::string> held;
  for (const double temp_c : question.command.temps_c) {
    const double at_c = question.at(temp_c)[calib::index_of(sensor.sensor)];
    const Reading ppm = read_scale(question.runtime, sensor.sensor, at_c);
    if (ppm.value && !ppm.in_range) held.push_back(fmt::format("{:g}", at_c));
  }
  if (held.empty()) return std::nullopt;
  const auto [low_c, high_c] = calib::domain_of(*sensor.scale_ppm);
  return calib::Warning{
      "scale_not_measured",
      fmt::format("{}: its scale error was measured from {:.2f} to {:.2f} °C only: no value at {} °C, "
                  "where the runtime holds it and says so",
                  calib::name_of(sensor.sensor), low_c, high_c, fmt::join(held, ", "))};
}

std::vector<calib::Warning> warnings_of(const Question& question) {
  std::vector<calib::Warning> warnings;
  if (auto warning = thermometer_warning(question)) warnings.push_back(*std::move(warning));
  for (const calib::SensorCalibration& sensor : question.calibration.sensors) {
    if (auto warning = scale_warning(question, sensor)) warnings.push_back(*std::move(warning));
  }
  return warnings;
}

std::string cell(const json& value, int digits) {
  return value.is_null() ? "–" : fmt::format("{:.{}f}", value.get<double>(), digits);
}

std::string heading(Sensor sensor) { return fmt::format("{} {}", calib::name_of(sensor), calib::printed_unit(sensor)); }

std::string describe(const Question& question, const json& points) {
  std::vector<std::vector<std::string>> table = {{"temp °C", "in range"}};
  for (const calib::SensorCalibration& sensor : question.calibration.sensors) {
    table.front().push_back(heading(sensor.sensor));
    if (sensor.scale_ppm) table.front().push_back(fmt::format("{} scale ppm", calib::name_of(sensor.sensor)));
  }
  for (const json& point : points) {
    std::vector<std::string> row = {fmt::format("{:g}", point["temp_c"].get<double>()),
                                    point["in_range"].get<bool>() ? "yes" : "NO, clamped"};
    for (const calib::SensorCalibration& sensor : question.calibration.sensors) {
      const std::string name(calib::name_of(sensor.sensor));
      row.push_back(cell(point["bias"][name], 6));
      if (sensor.scale_ppm) row.push_back(cell(point["scale_ppm"][name], 1));
    }
    table.push_back(std::move(row));
  }
  return text_table(table);
}

std::string describe_corrected(const json& points) {
  std::vector<std::vector<std::string>> table = {{"temp °C", "corrected", "flags"}};
  for (const Sensor sensor : calib::kSensors) table.front().push_back(heading(sensor));
  for (const json& point : points) {
    const json& corrected = point["corrected"];
    std::vector<std::string> row = {fmt::format("{:g}", point["temp_c"].get<double>()),
                                    corrected["status"].get<std::string>(),
                                    fmt::format("0x{:08x}", corrected["flags"].get<std::uint32_t>())};
    for (const Sensor sensor : calib::kSensors) {
      row.push_back(fmt::format("{:.7g}", corrected["out"][std::string(calib::name_of(sensor))].get<double>()));
    }
    table.push_back(std::move(row));
  }
  return text_table(table);
}

/// Refuses the temperature of a thermometer that a sensor of the file does not have.
base::Status check(const Question& question) {
  for (const Sensor sensor : calib::kSensors) {
    if (!question.command.own_temps_c[calib::index_of(sensor)] || question.own_thermometer(sensor)) continue;
    return base::bad_input(fmt::format("{} has no thermometer of its own in this file: --temp-c is its temperature",
                                       calib::name_of(sensor)),
                           "--own-temp-c");
  }
  return {};
}

json by_sensor(const std::array<std::optional<double>, calib::kSensorCount>& values) {
  json list = json::object();
  for (const Sensor sensor : calib::kSensors) {
    if (const auto& value = values[calib::index_of(sensor)]) list[std::string(calib::name_of(sensor))] = *value;
  }
  return list;
}

base::Status print_document(const Question& question, json points, Output& output) {
  std::vector<calib::Warning> all = waiver_warnings(question.calibration.references);
  const std::vector<calib::Warning> own = warnings_of(question);
  all.insert(all.end(), own.begin(), own.end());
  json warnings = json::array();
  for (const calib::Warning& warning : all) warnings.push_back({{"code", warning.code}, {"text", warning.text}});
  return output.print_json({{"unit", question.calibration.unit},
                            {"model", question.calibration.model_version},
                            {"raw", question.command.raw ? json(*question.command.raw) : json()},
                            {"own_temps_c", by_sensor(question.command.own_temps_c)},
                            {"points", std::move(points)},
                            {"warnings", std::move(warnings)}});
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
  const Question question{command, loaded->calibration, runtime};
  if (const auto sound = check(question); !sound) return sound;
  note_waivers(loaded->calibration.references, output);
  json points = json::array();
  for (const double temp_c : command.temps_c) points.push_back(evaluate_at(question, temp_c));
  if (output.json()) return print_document(question, std::move(points), output);
  for (const calib::Warning& warning : warnings_of(question)) output.note("warning: " + warning.text);
  output.print(fmt::format("unit {}, model {}{}\n{}{}", loaded->calibration.unit, loaded->calibration.model_version,
                           loaded->calibration.simulated ? " (SIMULATED)" : "", describe(question, points),
                           command.raw ? "\n" + describe_corrected(points) : ""));
  return {};
}

}  // namespace soak::station
