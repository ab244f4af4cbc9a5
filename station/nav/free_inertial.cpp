// SPDX-License-Identifier: Apache-2.0
#include "station/nav/free_inertial.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "nav/inertial/drift.h"
#include "station/io/output.h"
#include "station/nav/simulated_drive.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// What temperature adds to a sensor's bias on the way, and what the calibration leaves of it (95 %), in SI.
struct Change {
  double largest = 0.0;
  std::optional<double> left;  ///< absent: the calibration states no uncertainty
};

Change change_of(const calib::SensorCalibration& sensor, const TemperatureCourse& course) {
  const bool has_widths = !sensor.bias_uncertainty.temp_c.empty();
  const double begin = calib::evaluate(sensor.bias, course.from_c);
  const double begin_width = half_width(sensor.bias_uncertainty, course.from_c);
  Change change{0.0, has_widths ? std::optional(0.0) : std::nullopt};
  // The largest on the way, in steps of a degree. The sum of the half-widths holds whatever the curve's errors at the
  // two temperatures have to do with each other: where the runs scatter by a slope, they are opposite.
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(course.to_c - course.from_c))));
  for (int i = 1; i <= steps; ++i) {
    const double temp_c = std::lerp(course.from_c, course.to_c, static_cast<double>(i) / steps);
    change.largest = std::max(change.largest, std::abs(calib::evaluate(sensor.bias, temp_c) - begin));
    if (change.left) change.left = std::max(*change.left, begin_width + half_width(sensor.bias_uncertainty, temp_c));
  }
  return change;
}

json sensor_json(const calib::SensorCalibration& sensor, const TemperatureCourse& course, double gravity_mps2) {
  const Change change = change_of(sensor, course);
  const auto metres = [&](double bias, double t_s) {
    return calib::is_gyro(sensor.sensor) ? nav::drift_of_gyro_bias_m(bias, t_s, gravity_mps2)
                                         : nav::drift_of_accel_bias_m(bias, t_s);
  };
  const auto after = [&](double t_s) {
    return json{{"without", metres(change.largest, t_s)},
                {"with", change.left ? json(metres(*change.left, t_s)) : json()}};
  };
  const double printed = calib::printed_per_si(sensor.sensor);
  const char* interval = sensor.bias_uncertainty.pi95.empty() ? "ci95" : "pi95";
  return {{"sensor", calib::name_of(sensor.sensor)},
          {"unit", calib::printed_unit(sensor.sensor)},
          {"change", change.largest * printed},
          {"left", change.left ? json(*change.left * printed) : json()},
          {"left_interval", change.left ? json(interval) : json()},
          {"after_30_s_m", after(30.0)},
          {"after_60_s_m", after(60.0)}};
}

std::string shown(const json& number, int digits) {
  return number.is_null() ? "-" : fmt::format("{:.{}g}", number.get<double>(), digits);
}

}  // namespace

std::optional<TemperatureCourse> whole_range(const calib::Calibration& calibration) {
  if (calibration.sensors.empty()) return std::nullopt;
  TemperatureCourse range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    range.from_c = std::max(range.from_c, sensor.temp_min_c);
    range.to_c = std::min(range.to_c, sensor.temp_max_c);
  }
  return range.from_c < range.to_c ? std::optional(range) : std::nullopt;
}

json impact_json(const calib::Calibration& calibration, const TemperatureCourse& course) {
  json sensors = json::array();
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    sensors.push_back(sensor_json(sensor, course, calibration.gravity_mps2));
  }
  json warnings = json::array();
  for (const calib::Warning& warning : scatter_warnings(calibration)) {
    warnings.push_back({{"code", warning.code}, {"text", warning.text}});
  }
  return {{"from_c", course.from_c},
          {"to_c", course.to_c},
          {"free_inertial", std::move(sensors)},
          {"warnings", std::move(warnings)}};
}

json impact_json(const calib::Calibration& calibration) {
  const auto range = whole_range(calibration);
  return range ? impact_json(calibration, *range) : json();
}

std::string free_inertial_text(const json& sensors) {
  std::vector<std::vector<std::string>> table = {
      {"sensor", "change", "left", "95 % by", "unit", "30 s: m without", "with", "60 s: m without", "with"}};
  for (const json& sensor : sensors) {
    const json& interval = sensor["left_interval"];
    table.push_back({sensor["sensor"], shown(sensor["change"], 4), shown(sensor["left"], 2),
                     interval.is_null() ? "-" : interval.get<std::string>(), sensor["unit"]});
    for (const char* time : {"after_30_s_m", "after_60_s_m"}) {
      for (const char* which : {"without", "with"}) table.back().push_back(shown(sensor[time][which], 3));
    }
  }
  return "free-inertial position error from each sensor's bias, power-on constant removed, as if its axis lay "
         "horizontally\n" +
         text_table(table);
}

std::vector<calib::Warning> scatter_warnings(const calib::Calibration& calibration) {
  std::vector<std::string> of_one_run;
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    const calib::UncertaintyTable& stated = sensor.bias_uncertainty;
    if (!stated.temp_c.empty() && stated.pi95.empty()) of_one_run.emplace_back(calib::name_of(sensor.sensor));
  }
  if (of_one_run.empty()) return {};
  return {
      {"one_run", fmt::format("the model rests on one run for {}: how the curve of the next power-on scatters is not "
                              "known, and 'left' and 'with' (by ci95) may be far too small; record more runs: at "
                              "least three power-ons",
                              fmt::join(of_one_run, ", "))}};
}

}  // namespace soak::station
