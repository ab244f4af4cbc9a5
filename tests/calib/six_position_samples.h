// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "calib/estimate/six_position.h"

namespace soak::calib::test {

inline constexpr double kGravity_mps2 = 9.80665;

/// One stop of a fixture: a face up, and the rate it turns at about the vertical.
struct Stop {
  std::string face;
  double rate_dps = 0.0;
};

/// Truth of a unit whose three axes are alike, and what its fixture does. Noise is that of segment means.
struct Bench {
  std::vector<Stop> stops = {{"+X"}, {"-X"}, {"+Y"}, {"-Y"}, {"+Z"}, {"-Z"}};
  std::vector<double> plateaus_c = {-20, -10, 0, 10, 20};
  std::function<double(double)> gyro_bias = [](double t) { return 0.01 + 1e-4 * t; };
  std::function<double(double)> gyro_scale_ppm = [](double t) { return -1500.0 + 40.0 * t; };
  std::function<double(double)> accel_bias = [](double t) { return 0.05 - 1e-3 * t; };  ///< at 0 g
  std::function<double(double)> accel_scale_ppm = [](double t) { return 2000.0 + 30.0 * t; };
  Vector3 accel_coupling = {0.002, -0.003, 0.001};  ///< to x, y, z; the own axis' is left out
  Vector3 gyro_coupling = {3e-5, -2e-5, 4e-5};      ///< to x, y, z, (rad/s)/(m/s²)
  double even_order = 0.0;                          ///< K₂, 1/(m/s²)
  double lever_m = 0.0;                             ///< of the accelerometers from the axis of rotation
  double gyro_noise = 0.0;
  double accel_noise = 0.0;
  std::uint64_t seed = 1;
};

/// Readings at one stop, written out from the sign rule raw = (1 + S)·f + b + Σ M f + K₂ f².
inline double gyro_reading(const Bench& bench, double temp_c, std::size_t axis, const Vector3& up, double rate_rps) {
  double y = bench.gyro_bias(temp_c) + (1.0 + 1e-6 * bench.gyro_scale_ppm(temp_c)) * rate_rps * up[axis];
  for (std::size_t j = 0; j < 3; ++j) y += bench.gyro_coupling[j] * kGravity_mps2 * up[j];
  return y;
}

inline double accel_reading(const Bench& bench, double temp_c, std::size_t axis, const Vector3& up, double rate_rps) {
  const double f = kGravity_mps2 * up[axis] + (up[axis] == 0.0 ? bench.lever_m * rate_rps * rate_rps : 0.0);
  double y = bench.accel_bias(temp_c) + (1.0 + 1e-6 * bench.accel_scale_ppm(temp_c)) * f + bench.even_order * f * f;
  for (std::size_t j = 0; j < 3; ++j) y += j == axis ? 0.0 : bench.accel_coupling[j] * kGravity_mps2 * up[j];
  return y;
}

/// Segments of one run: every stop at every plateau, ten minutes apart.
inline std::vector<Segment> segments_of(const Bench& bench) {
  std::vector<Segment> segments;
  base::Random random(bench.seed);
  double t_s = 0.0;
  for (std::size_t p = 0; p < bench.plateaus_c.size(); ++p, t_s += 1800.0) {
    for (const Stop& stop : bench.stops) {
      Segment s;
      s.key = {"run", "U", static_cast<std::int32_t>(p), stop.face, 0};
      s.plateau_c = bench.plateaus_c[p];
      s.sweep = Sweep::up;
      s.position = *position_named(stop.face);
      if (stop.rate_dps != 0.0) {
        s.position->rate_dps = stop.rate_dps;
        s.key.position = s.position->label = stop.face + " at " + std::to_string(stop.rate_dps);
      }
      s.t_start_s = t_s;
      s.t_end_s = (t_s += 600.0) - 10.0;
      s.temp_c = bench.plateaus_c[p];
      s.sensor_temp_c.fill(s.temp_c);
      for (const Sensor sensor : kSensors) {
        const double noise = is_gyro(sensor) ? bench.gyro_noise : bench.accel_noise;
        const double mean = (is_gyro(sensor) ? gyro_reading : accel_reading)(
            bench, s.temp_c, axis_of(sensor), s.position->up, stop.rate_dps * base::kRadPerDeg);
        s.sensor[index_of(sensor)] = {600, mean + noise * random.gaussian(), 600.0 * noise * noise, noise};
      }
      segments.push_back(s);
    }
  }
  return segments;
}

inline Site standard_site() {
  return {.latitude_deg = {}, .height_m = {}, .azimuth_deg = {}, .gravity_mps2 = kGravity_mps2};
}

inline SixPositionEstimate estimate(const Bench& bench) {
  return estimate_six_positions(segments_of(bench), standard_site(), {});
}

/// The text of the warnings with that code, joined by lines.
inline std::string texts(const std::vector<Warning>& warnings, const std::string& code) {
  std::string all;
  for (const Warning& warning : warnings) {
    if (warning.code == code) all += warning.text + "\n";
  }
  return all;
}

}  // namespace soak::calib::test
