// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"
#include "base/units.h"
#include "calib/segments/data_gate.h"
#include "calib/segments/segmentation.h"

// Simulated units at rest for the tests of the data gate, and what they are done to.
namespace soak::calib::gate_samples {

inline constexpr double kG = 9.80665;
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// How a simulated unit at rest reads; noise is of single samples.
struct Still {
  double seconds = 60.0;
  double rate_hz = 100.0;
  std::string position = "+Z";
  double gyro_noise_rps = 1e-3;  ///< 0.06 deg/s
  double accel_noise_mps2 = 0.01;
  double gyro_lsb_rps = 0.0;  ///< 0 = not rounded
  double accel_lsb_mps2 = 0.0;
  double slow_share = 0.0;  ///< of the noise's standard deviation: Gauss-Markov with 20 s correlation time
  double temp_rate_kpmin = 0.01;
  double bias_per_k_rps = 1e-4;   ///< 0.006 deg/s per kelvin
  double bias_per_k_mps2 = 3e-3;  ///< 0.3 m/s² over 100 K
  double temp_noise_c = 0.01;
  double temp_lsb_c = 0.0;
};

inline double rounded(double value, double lsb) { return lsb > 0.0 ? std::round(value / lsb) * lsb : value; }

/// One segment at 25 °C.
inline Recording still(const Still& how, std::uint64_t seed) {
  base::Random random(seed);
  Recording r;
  r.run_id = "run";
  r.unit = "U";
  r.positions = {*position_named(how.position)};
  const auto rows = static_cast<std::size_t>(how.seconds * how.rate_hz);
  std::array<double, kSensorCount> slow{};
  const double step_s = 1.0 / how.rate_hz;
  const double keep = std::exp(-step_s / 20.0);
  for (std::size_t i = 0; i < rows; ++i) {
    const double t_s = static_cast<double>(i) * step_s;
    const double warming_k = how.temp_rate_kpmin * t_s / 60.0;
    r.t_s.push_back(t_s);
    r.temp_c.push_back(rounded(25.0 + warming_k + how.temp_noise_c * random.gaussian(), how.temp_lsb_c));
    r.plateau_c.push_back(25.0);
    r.position.push_back(0);
    for (const Sensor sensor : kSensors) {
      const std::size_t s = index_of(sensor);
      const bool gyro = is_gyro(sensor);
      const double noise = gyro ? how.gyro_noise_rps : how.accel_noise_mps2;
      slow[s] = keep * slow[s] + std::sqrt(1.0 - keep * keep) * how.slow_share * noise * random.gaussian();
      const double force = gyro ? 0.0 : kG * r.positions[0].up[axis_of(sensor)];
      const double bias = (gyro ? 0.01 : 0.1) + warming_k * (gyro ? how.bias_per_k_rps : how.bias_per_k_mps2);
      const double value = force + bias + slow[s] + noise * random.gaussian();
      r.sensor[s].push_back(rounded(value, gyro ? how.gyro_lsb_rps : how.accel_lsb_mps2));
    }
  }
  return r;
}

/// Findings of all segments of a recording, one after the other.
inline std::vector<Finding> findings_of(const Recording& r, const UnitType& type = {}) {
  const auto cut = segment(r);
  if (!cut || cut->segments.empty()) throw std::runtime_error("no segment");
  std::vector<Finding> all;
  for (const auto& found : examine(r, cut->segments, type)) all.insert(all.end(), found.begin(), found.end());
  return all;
}

inline std::string listed(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& f : findings) text += f.code + " (" + std::string(name_of(f.severity)) + "): " + f.text + "\n";
  return text;
}

/// The only finding; a failure where there is none or another.
inline Finding only(const std::vector<Finding>& findings) {
  EXPECT_EQ(findings.size(), 1U) << listed(findings);
  return findings.empty() ? Finding{} : findings.front();
}

inline void expect_clean(const Recording& r, const UnitType& type = {}) {
  const auto findings = findings_of(r, type);
  EXPECT_TRUE(findings.empty()) << listed(findings);
}

inline std::vector<double>& sensor(Recording& r, Sensor which) { return r.sensor[index_of(which)]; }

/// Turns what the accelerometers read in rows [first, last) by an angle about the y axis.
inline void tilt(Recording& r, std::size_t first, std::size_t last, double angle_deg) {
  const double c = std::cos(angle_deg * base::kRadPerDeg);
  const double s = std::sin(angle_deg * base::kRadPerDeg);
  for (std::size_t i = first; i < last; ++i) {
    const double x = sensor(r, Sensor::accel_x)[i];
    const double z = sensor(r, Sensor::accel_z)[i];
    sensor(r, Sensor::accel_x)[i] = c * x + s * z;
    sensor(r, Sensor::accel_z)[i] = c * z - s * x;
  }
}

/// Appends another recording of the same unit as a later segment at the same plateau.
inline void append(Recording& r, const Recording& more) {
  const double offset_s = r.t_s.back() + 100.0;
  for (std::size_t i = 0; i < more.rows(); ++i) r.t_s.push_back(offset_s + more.t_s[i]);
  const auto join = [](auto& a, const auto& b) { a.insert(a.end(), b.begin(), b.end()); };
  join(r.temp_c, more.temp_c);
  join(r.plateau_c, more.plateau_c);
  join(r.position, more.position);
  for (std::size_t s = 0; s < kSensorCount; ++s) join(r.sensor[s], more.sensor[s]);
}

/// A run of one visit with several positions in turn; `change` may alter each before it is appended.
template <class Change>
inline Recording positions_in_turn(const std::vector<std::string>& labels, const Still& how, const Change& change) {
  Recording all;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    Still here = how;
    here.position = labels[i];
    Recording r = still(here, 100 + i);
    change(r, i);
    std::fill(r.position.begin(), r.position.end(), static_cast<std::int32_t>(i));
    if (i == 0) {
      all = std::move(r);
    } else {
      append(all, r);
      all.positions.push_back(r.positions[0]);
    }
  }
  return all;
}

inline const std::vector<std::string> kSix = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};

}  // namespace soak::calib::gate_samples
