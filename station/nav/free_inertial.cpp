// SPDX-License-Identifier: Apache-2.0
#include "station/nav/free_inertial.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "nav/inertial/drift.h"
#include "station/io/output.h"
#include "station/nav/simulated_drive.h"

namespace soak::station {
namespace {

using nlohmann::json;

json metres_json(double without_m, double with_m) { return {{"without", without_m}, {"with", with_m}}; }

}  // namespace

json free_inertial_json(const calib::Calibration& calibration, double from_c, double to_c) {
  json sensors = json::array();
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    double change = 0.0;
    double left = 0.0;
    const double begin = calib::evaluate(sensor.bias, from_c);
    const double begin_width = half_width(sensor.bias_uncertainty, from_c);
    // The largest on the way, in steps of a degree. The sum of the half-widths holds whatever the curve's errors at the
    // two temperatures have to do with each other: where the runs scatter by a slope, they are opposite.
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to_c - from_c))));
    for (int i = 1; i <= steps; ++i) {
      const double temp_c = std::lerp(from_c, to_c, static_cast<double>(i) / steps);
      change = std::max(change, std::abs(calib::evaluate(sensor.bias, temp_c) - begin));
      left = std::max(left, begin_width + half_width(sensor.bias_uncertainty, temp_c));
    }
    const auto after = [&](double bias, double t_s) {
      return calib::is_gyro(sensor.sensor) ? nav::drift_of_gyro_bias_m(bias, t_s, calibration.gravity_mps2)
                                           : nav::drift_of_accel_bias_m(bias, t_s);
    };
    const double printed = calib::printed_per_si(sensor.sensor);
    sensors.push_back({{"sensor", calib::name_of(sensor.sensor)},
                       {"unit", calib::printed_unit(sensor.sensor)},
                       {"change", change * printed},
                       {"left", left * printed},
                       {"left_interval", sensor.bias_uncertainty.pi95.empty() ? "ci95" : "pi95"},
                       {"after_30_s_m", metres_json(after(change, 30.0), after(left, 30.0))},
                       {"after_60_s_m", metres_json(after(change, 60.0), after(left, 60.0))}});
  }
  return sensors;
}

std::string free_inertial_text(const json& sensors) {
  std::vector<std::vector<std::string>> table = {
      {"sensor", "change", "left", "95 % by", "unit", "30 s: m without", "with", "60 s: m without", "with"}};
  for (const json& sensor : sensors) {
    table.push_back({sensor["sensor"], fmt::format("{:.4g}", sensor["change"].get<double>()),
                     fmt::format("{:.2g}", sensor["left"].get<double>()), sensor["left_interval"], sensor["unit"]});
    for (const char* time : {"after_30_s_m", "after_60_s_m"}) {
      for (const char* which : {"without", "with"}) {
        table.back().push_back(fmt::format("{:.3g}", sensor[time][which].get<double>()));
      }
    }
  }
  return "free-inertial position error from each sensor's bias, power-on constant removed, as if its axis lay "
         "horizontally\n" +
         text_table(table);
}

std::vector<calib::Warning> scatter_warnings(const calib::Calibration& calibration) {
  std::vector<std::string> of_one_run;
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    if (sensor.bias_uncertainty.pi95.empty()) of_one_run.emplace_back(calib::name_of(sensor.sensor));
  }
  if (of_one_run.empty()) return {};
  return {
      {"one_run", fmt::format("the model rests on one run for {}: how the curve of the next power-on scatters is not "
                              "known, and 'left' and 'with' (by ci95) may be far too small; record more runs: at "
                              "least three power-ons",
                              fmt::join(of_one_run, ", "))}};
}

}  // namespace soak::station
