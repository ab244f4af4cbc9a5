// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "calib/curve/calibration.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib::samples {

/// Six sensors valid from `min_c` to `max_c`, each with the bias curve that `bias` gives.
inline Calibration six_sensors(double min_c, double max_c, const std::function<Curve(Sensor)>& bias) {
  Calibration calibration = provenance("SN-0004");
  for (const Sensor sensor : kSensors) {
    SensorCalibration one;
    one.sensor = sensor;
    one.temp_min_c = min_c;
    one.temp_max_c = max_c;
    one.model = "anfis";
    one.bias = bias(sensor);
    calibration.sensors.push_back(one);
  }
  return calibration;
}

/// f(T) as a table so fine that its straight pieces do not matter: 0.01 °C.
inline TableCurve fine_table(double min_c, double max_c, const std::function<double(double)>& f) {
  TableCurve table{min_c, 0.01, {}};
  for (double n = 0.0; min_c + 0.01 * n < max_c + 0.005; n += 1.0) table.values.push_back(f(min_c + 0.01 * n));
  return table;
}

/// Bias that an independent reader of the golden calibrations' curves would take: the curve itself, held at the ends of
/// a range.
inline double held(const Curve& curve, double temp_c, double min_c, double max_c) {
  return evaluate(curve, temp_c < min_c ? min_c : temp_c > max_c ? max_c : temp_c);
}

/// The words of each line that is no comment.
inline std::vector<std::vector<std::string>> parameter_lines(const std::string& text) {
  std::vector<std::vector<std::string>> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    lines.emplace_back();
    for (std::string word; words >> word;) lines.back().push_back(word);
  }
  return lines;
}

}  // namespace soak::calib::samples
