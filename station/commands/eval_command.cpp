// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "calib/curve/one_way.h"
#include "calib/runtime/soak_runtime.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/records/calibration_reader.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

/// soak eval FILE.blob --temp-c T[,T...]
struct EvalCommand final : Command {
  std::string file;
  std::vector<double> temps_c;  ///< finite
  /// Of sensors with a thermometer of their own, at all temps_c.
  std::array<std::optional<double>, calib::kSensorCount> own_temps_c;
  std::optional<std::array<double, calib::kSensorCount>> raw;  ///< sample to correct, deg/s and m/s²

  void declare(OptionList& options) override;
  base::Status run(Output& output) override;
};

/// SENSOR=T between commas, no sensor twice.
base::Status read_own_temperatures(const std::string& list, EvalCommand& command) {
  static const std::string kMustBe =
      "a temperature from -273.15 to 1000 for each sensor, such as gyro_x=33,gyro_y=33.5";
  for (std::size_t first = 0; first <= list.size();) {
    const std::size_t last = std::min(list.find(',', first), list.size());
    const std::string part = list.substr(first, last - first);
    const std::size_t equals = std::min(part.find('='), part.size());
    const auto sensor = calib::sensor_named(part.substr(0, equals));
    if (!sensor || equals == part.size()) return base::bad_input("must be " + kMustBe);
    auto& temp_c = command.own_temps_c[calib::index_of(*sensor)];
    if (temp_c) return base::bad_input(part.substr(0, equals) + " is given twice");
    std::vector<double> values;
    if (auto read = number_list(values, -273.15, 1000.0, kMustBe)(part.substr(equals + 1)); !read) return read;
    temp_c = values.front();
    first = last + 1;
  }
  return {};
}

/// Six numbers, gyros in deg/s and accelerometers in m/s².
base::Status read_sample(const std::string& list, EvalCommand& command) {
  static const std::string kMustBe = "six numbers GX,GY,GZ,AX,AY,AZ, rates in deg/s and accelerations in m/s2";
  std::vector<double> values;
  if (auto read = number_list(values, -1e9, 1e9, kMustBe)(list); !read) return read;
  if (values.size() != calib::kSensorCount) return base::bad_input("must be " + kMustBe);
  std::ranges::copy(values, command.raw.emplace().begin());
  return {};
}

void EvalCommand::declare(OptionList& options) {
  options.add("file FILE.blob", &file, "Calibration file").required();
  options
      .add("--temp-c T[,T...]",
           number_list(temps_c, -273.15, 1000.0,
                       "temperatures from -273.15 to 1000 separated by commas, such as -30,25,70"),
           "Temperatures in °C")
      .required();
  options.add(
      "--own-temp-c SENSOR=T[,...]", [this](const std::string& list) { return read_own_temperatures(list, *this); },
      "Temperatures of sensors that were calibrated with their own thermometers");
  options.add(
      "--raw GX,GY,GZ,AX,AY,AZ", [this](const std::string& list) { return read_sample(list, *this); },
      "Also correct this sample (deg/s, m/s2) as the runtime does, with all cross-couplings: for test vectors");
}

using calib::Sensor;
using nlohmann::json;

/// Temperature of each sensor's thermometer; NaN: of its own, and not given.
using Temperatures = std::array<double, calib::kSensorCount>;

/// What to evaluate, and the file.
struct Evaluation {
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

/// What the runtime returns for one quantity of one sensor; nothing where the file has none.
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

std::string_view name_of_status(soak_status status) {
  return status == SOAK_OK ? "ok" : status == SOAK_CLAMPED ? "clamped" : status == SOAK_ABSENT ? "absent" : "invalid";
}

/// The sample as the runtime corrects it. Without --own-temp-c as firmware does that has one temperature.
json corrected_at(const Evaluation& asked, double temp_c) {
  float raw[calib::kSensorCount];
  float out[calib::kSensorCount];
  float temps_c[calib::kSensorCount];
  std::uint32_t flags = 0;
  const Temperatures at = asked.at(temp_c);
  for (const Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    raw[s] = static_cast<float>((*asked.command.raw)[s] / calib::printed_per_si(sensor));
    temps_c[s] = static_cast<float>(at[s]);
  }
  const bool several = std::ranges::any_of(asked.command.own_temps_c, [](const auto& t) { return t.has_value(); });
  const soak_status status = several ? soak_apply_temps(&asked.runtime, temps_c, raw, out, &flags)
                                     : soak_apply(&asked.runtime, static_cast<float>(temp_c), raw, out, &flags);
  json values = json::object();
  for (const Sensor sensor : calib::kSensors) {
    values[std::string(calib::name_of(sensor))] =
        static_cast<double>(out[calib::index_of(sensor)]) * calib::printed_per_si(sensor);
  }
  return {{"status", name_of_status(status)}, {"flags", flags}, {"out", std::move(values)}};
}

json evaluate_at(const Evaluation& asked, double temp_c) {
  const Temperatures temps_c = asked.at(temp_c);
  json bias = json::object();
  json scale = json::object();
  bool in_range = true;
  for (const calib::SensorCalibration& stated : asked.calibration.sensors) {
    const std::string name(calib::name_of(stated.sensor));
    const double at_c = temps_c[calib::index_of(stated.sensor)];
    const Reading reading = read_bias(asked.runtime, stated.sensor, at_c);
    const Reading ppm = read_scale(asked.runtime, stated.sensor, at_c);
    in_range = in_range && reading.in_range;
    bias[name] = reading.value ? json(*reading.value * calib::printed_per_si(stated.sensor)) : json();
    scale[name] = ppm.in_range ? number_or_null(ppm.value) : json();
  }
  return {{"temp_c", temp_c},
          {"in_range", in_range},
          {"bias", std::move(bias)},
          {"scale_ppm", std::move(scale)},
          {"corrected", asked.command.raw ? corrected_at(asked, temp_c) : json()}};
}

/// Sensors with thermometers of their own whose temperatures the command does not give.
std::optional<calib::Warning> thermometer_warning(const Evaluation& asked) {
  std::vector<std::string> names;
  std::vector<std::string> wanted;
  for (const Sensor sensor : calib::kSensors) {
    if (!asked.own_thermometer(sensor) || asked.command.own_temps_c[calib::index_of(sensor)]) continue;
    names.emplace_back(calib::name_of(sensor));
    wanted.push_back(names.back() + "=T");
  }
  if (names.empty()) return std::nullopt;
  return calib::Warning{"own_thermometer",
                        fmt::format("{}: no value, because it was calibrated with its own thermometer, whose reading "
                                    "--temp-c does not give; add --own-temp-c {}",
                                    fmt::join(names, ", "), fmt::join(wanted, ","))};
}

/// Where the scale factor of a sensor was not measured.
std::optional<calib::Warning> scale_warning(const Evaluation& asked, const calib::SensorCalibration& sensor) {
  std::vector<std::string> held;
  for (const double temp_c : asked.command.temps_c) {
    const double at_c = asked.at(temp_c)[calib::index_of(sensor.sensor)];
    const Reading ppm = read_scale(asked.runtime, sensor.sensor, at_c);
    if (ppm.value && !ppm.in_range) held.push_back(fmt::format("{:g}", at_c));
  }
  if (held.empty()) return std::nullopt;
  const auto [low_c, high_c] = calib::domain_of(*sensor.scale_ppm);
  return calib::Warning{"scale_not_measured",
                        fmt::format("{}: the scale error was measured from {:.2f} to {:.2f} °C only: no value at {} "
                                    "°C, where the runtime uses the value at the nearest end and sets a flag",
                                    calib::name_of(sensor.sensor), low_c, high_c, fmt::join(held, ", "))};
}

/// What the half-widths of the file do not hold, or hold only as others state it; of all sensors alike once.
std::vector<calib::Warning> band_warnings_of(const calib::Calibration& calibration) {
  std::vector<calib::Warning> warnings;
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    if (sensor.bias_uncertainty.one_run && warnings.empty()) {
      warnings.push_back(
          {"one_run", "the file is of one run: its bands do not hold the scatter from power-on to power-on"});
    }
  }
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    if (!sensor.one_way) continue;
    calib::Warning warning{"one_way",
                           fmt::format("in the runs of the file {}, and {}", one_way_text(sensor.one_way->ranges),
                                       one_way_bands_text(sensor.one_way->known.source))};
    if (std::ranges::find(warnings, warning.text, &calib::Warning::text) != warnings.end()) continue;
    warnings.push_back(std::move(warning));
  }
  return warnings;
}

std::vector<calib::Warning> warnings_of(const Evaluation& asked) {
  std::vector<calib::Warning> warnings = band_warnings_of(asked.calibration);
  if (auto warning = thermometer_warning(asked)) warnings.push_back(*std::move(warning));
  for (const calib::SensorCalibration& sensor : asked.calibration.sensors) {
    if (auto warning = scale_warning(asked, sensor)) warnings.push_back(*std::move(warning));
  }
  return warnings;
}

std::string eval_cell(const json& value, int digits) {
  return value.is_null() ? "–" : fmt::format("{:.{}f}", value.get<double>(), digits);
}

std::string eval_heading(Sensor sensor) {
  return fmt::format("{} {}", calib::name_of(sensor), calib::printed_unit(sensor));
}

std::string points_table(const Evaluation& asked, const json& points) {
  std::vector<std::vector<std::string>> table = {{"temp °C", "in range"}};
  for (const calib::SensorCalibration& sensor : asked.calibration.sensors) {
    table.front().push_back(eval_heading(sensor.sensor));
    if (sensor.scale_ppm) table.front().push_back(fmt::format("{} scale ppm", calib::name_of(sensor.sensor)));
  }
  for (const json& point : points) {
    std::vector<std::string> row = {fmt::format("{:g}", point["temp_c"].get<double>()),
                                    point["in_range"].get<bool>() ? "yes" : "NO, clamped"};
    for (const calib::SensorCalibration& sensor : asked.calibration.sensors) {
      const std::string name(calib::name_of(sensor.sensor));
      row.push_back(eval_cell(point["bias"][name], 6));
      if (sensor.scale_ppm) row.push_back(eval_cell(point["scale_ppm"][name], 1));
    }
    table.push_back(std::move(row));
  }
  return text_table(table);
}

std::string corrected_table(const json& points) {
  std::vector<std::vector<std::string>> table = {{"temp °C", "corrected", "flags"}};
  for (const Sensor sensor : calib::kSensors) table.front().push_back(eval_heading(sensor));
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

/// Fails for the temperature of a thermometer that the sensor does not have in this file.
base::Status check_own_temperatures(const Evaluation& asked) {
  for (const Sensor sensor : calib::kSensors) {
    if (!asked.command.own_temps_c[calib::index_of(sensor)] || asked.own_thermometer(sensor)) continue;
    return base::bad_input(fmt::format("{} has no thermometer of its own in this file: --temp-c gives its temperature",
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

base::Status print_document(const Evaluation& asked, json points, Output& output) {
  std::vector<calib::Warning> all = waiver_warnings(asked.calibration.references);
  const std::vector<calib::Warning> own = warnings_of(asked);
  all.insert(all.end(), own.begin(), own.end());

  return output.print_json({{"unit", asked.calibration.unit},
                            {"model", asked.calibration.model_version},
                            {"simulated", asked.calibration.simulated},
                            {"unreleased", asked.calibration.unreleased},
                            {"raw", asked.command.raw ? json(*asked.command.raw) : json()},
                            {"own_temps_c", by_sensor(asked.command.own_temps_c)},
                            {"points", std::move(points)},
                            {"warnings", warnings_json(all)}});
}

base::Status EvalCommand::run(Output& output) {
  const auto loaded = read_calibration(file);
  if (!loaded) return base::forward_error(loaded);
  soak_cal runtime;
  if (const soak_status status = soak_load(&runtime, loaded->bytes.data(), loaded->bytes.size()); status != SOAK_OK) {
    return base::corrupt(
        fmt::format("the deployment runtime cannot load the file (status {})", static_cast<int>(status)), file);
  }
  const Evaluation asked{*this, loaded->calibration, runtime};
  if (const auto sound = check_own_temperatures(asked); !sound) return sound;
  note_waivers(loaded->calibration.references, output);
  json points = json::array();
  for (const double temp_c : temps_c) points.push_back(evaluate_at(asked, temp_c));
  if (output.json()) return print_document(asked, std::move(points), output);
  for (const calib::Warning& warning : warnings_of(asked)) output.note("warning: " + warning.text);
  output.print(fmt::format("unit {}, model {}{}\n{}{}", loaded->calibration.unit, loaded->calibration.model_version,
                           marks_text(loaded->calibration), points_table(asked, points),
                           raw ? "\n" + corrected_table(points) : ""));
  return {};
}

}  // namespace

CommandGroup eval_commands() {
  return {"",
          "",
          {{"eval", "Evaluate a calibration file with the deployment runtime",
            "soak eval SN0042.soakcal --temp-c -30,25,70", std::make_shared<EvalCommand>()}}};
}

}  // namespace soak::station
