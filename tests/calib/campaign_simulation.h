// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "base/random.h"
#include "calib/model/unit_model.h"
#include "calib/vocabulary/sensor.h"

/// Campaigns of one unit made up as segment statistics, from physics written down here anew: what the coverage of
/// stated uncertainties is judged by.
namespace soak::calib::simulated {

/// What nature draws once per campaign from the standard uncertainties that the laboratory states, and how the unit
/// scatters. SI.
struct Scatter {
  double face_tilt_rad = 0.1 * std::numbers::pi / 180.0;  ///< each face about each of its two axes
  double gravity_mps2 = 3e-4;
  double thermometer_c = 0.1;  ///< temperature of the sensing element at a reading, campaign against deployment
  double gyro_run_rps = 0.02 * std::numbers::pi / 180.0;  ///< bias of one power-on
  double gyro_noise_rps = 0.005 * std::numbers::pi / 180.0;
  double gyro_visit_rps = 0.002 * std::numbers::pi / 180.0;  ///< of one plateau visit, all positions alike
  double accel_run_mps2 = 0.01;
  double accel_noise_mps2 = 0.003;
  double accel_visit_mps2 = 0.001;
};

inline constexpr double kGravity_mps2 = 9.81;
inline constexpr double kLatitude_deg = 51.0;
inline constexpr double kEarth_rps = 7.292115e-5;

/// Smooth saturating stress, a thermally activated part and one local feature, of given span over -30..70 °C.
struct ThermalCurve {
  double level = 0.0;
  double scale = 0.0;
  double centre_c = 0.0;
  double width_c = 30.0;
  double activated = 0.0;
  double feature = 0.0;
  double feature_c = 0.0;
  double feature_width_c = 8.0;

  static ThermalCurve draw(base::Random& random, double level, double span, double feature) {
    ThermalCurve curve;
    curve.level = level * (2.0 * random.uniform() - 1.0);
    curve.scale = span / 2.0 * (random.uniform() < 0.5 ? -1.0 : 1.0);
    curve.centre_c = -15.0 + 70.0 * random.uniform();
    curve.width_c = 18.0 + 27.0 * random.uniform();
    curve.activated = span * (random.uniform() - 0.5);
    curve.feature = feature * (random.uniform() < 0.5 ? -1.0 : 1.0);
    curve.feature_c = -20.0 + 80.0 * random.uniform();
    curve.feature_width_c = 6.0 + 3.0 * random.uniform();
    return curve;
  }

  [[nodiscard]] double at(double temp_c) const {
    constexpr double kBoltzmann_ev = 8.617e-5;
    const double hot = 1.0 / (70.0 + 273.15);
    const double arrhenius = std::exp(-0.25 / kBoltzmann_ev * (1.0 / (temp_c + 273.15) - hot));
    const double z = (temp_c - feature_c) / feature_width_c;
    return level + scale * std::atan((temp_c - centre_c) / width_c) + activated * arrhenius +
           feature * std::exp(-0.5 * z * z);
  }
};

/// One gyro and one accelerometer along the same axis, and the campaign that they are measured in.
struct Truth {
  ThermalCurve gyro_bias;    ///< rad/s
  ThermalCurve accel_bias;   ///< m/s²
  ThermalCurve accel_scale;  ///< ppm
  Vector3 g_sensitivity{};   ///< (rad/s)/(m/s²)
  Vector3 misalignment{};    ///< rad; 0 on the own axis

  static Truth draw(base::Random& random, Sensor gyro) {
    constexpr double kRad = std::numbers::pi / 180.0;
    Truth truth;
    truth.gyro_bias = ThermalCurve::draw(random, 0.3 * kRad, 0.5 * kRad, 0.1 * kRad);
    truth.accel_bias = ThermalCurve::draw(random, 0.15, 0.3, 0.035);
    truth.accel_scale = ThermalCurve::draw(random, 2000.0, 1200.0, 0.0);
    for (std::size_t j = 0; j < 3; ++j) {
      truth.g_sensitivity[j] = 0.02 * kRad / 9.81 * random.gaussian();
      truth.misalignment[j] = j == axis_of(gyro) ? 0.0 : 0.002 * random.gaussian();
    }
    return truth;
  }
};

using Matrix3 = std::array<Vector3, 3>;  ///< rows

inline double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// `v` turned by the small rotation `by`, exactly enough for tilts of a degree: v + by × v + by × (by × v) / 2.
inline Vector3 turned(const Vector3& v, const Vector3& by) {
  const auto cross = [](const Vector3& a, const Vector3& b) {
    return Vector3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const Vector3 once = cross(by, v);
  const Vector3 twice = cross(by, once);
  return {v[0] + once[0] + twice[0] / 2, v[1] + once[1] + twice[1] / 2, v[2] + once[2] + twice[2] / 2};
}

/// A campaign of `runs` runs over -30..70 °C and back in steps of 5 °C with one axis' gyro and accelerometer.
inline UnitInput campaign(const Truth& truth, Sensor gyro, int runs, const Scatter& scatter, base::Random& random) {
  const std::size_t axis = axis_of(gyro);
  const std::size_t accel = axis + 3;
  const double g = kGravity_mps2 + scatter.gravity_mps2 * random.gaussian();
  const double element_c = scatter.thermometer_c * random.gaussian();
  constexpr double kRad = std::numbers::pi / 180.0;
  const double vertical = kEarth_rps * std::sin(kLatitude_deg * kRad);
  const double horizontal = kEarth_rps * std::cos(kLatitude_deg * kRad);
  struct Face {
    Position position;
    Vector3 up;
    Vector3 north;
  };
  std::vector<Face> faces;
  for (const auto name : kSixPositionLabels) {
    Face face;
    face.position = *position_named(name);
    Vector3 tilt;
    for (double& angle : tilt) angle = scatter.face_tilt_rad * random.gaussian();
    const auto& up = face.position.up;
    Vector3 north{};
    north[up[0] != 0.0 ? 1 : up[1] != 0.0 ? 2 : 0] = 1.0;
    face.up = turned(up, tilt);
    face.north = turned(north, tilt);
    faces.push_back(face);
  }
  UnitInput input;
  input.unit = "U";
  for (int r = 0; r < runs; ++r) {
    RunInput run;
    run.run_id = run.label = "R" + std::to_string(r);
    run.site.gravity_mps2 = kGravity_mps2;
    run.site.latitude_deg = kLatitude_deg;
    const double gyro_offset = scatter.gyro_run_rps * random.gaussian();
    const double accel_offset = scatter.accel_run_mps2 * random.gaussian();
    double t_s = 0.0;
    for (int visit = 0; visit < 41; ++visit) {
      const double plateau_c = -30.0 + 5.0 * (visit <= 20 ? visit : 40 - visit);
      const double settled_c = plateau_c + 0.2 * (2.0 * random.uniform() - 1.0);
      const double gyro_visit = scatter.gyro_visit_rps * random.gaussian();
      const double accel_visit = scatter.accel_visit_mps2 * random.gaussian();
      for (const Face& face : faces) {
        Segment s;
        s.key = {run.run_id, "U", visit, face.position.label, 0};
        s.plateau_c = plateau_c;
        s.sweep = visit <= 20 ? Sweep::up : Sweep::down;
        s.position = face.position;
        s.t_start_s = t_s;
        s.t_end_s = t_s += 600.0;
        s.temp_c = settled_c + 0.02 * random.gaussian();
        s.sensor_temp_c.fill(s.temp_c);
        const double there_c = s.temp_c + element_c;
        Vector3 force = face.up;
        for (double& f : force) f *= g;
        const double rate = vertical * face.up[axis] + horizontal * face.north[axis];
        const double gyro_mean = truth.gyro_bias.at(there_c) + gyro_offset + gyro_visit + rate +
                                 dot(truth.g_sensitivity, force) + scatter.gyro_noise_rps * random.gaussian();
        const double accel_mean = truth.accel_bias.at(there_c) + accel_offset + accel_visit +
                                  (1.0 + 1e-6 * truth.accel_scale.at(there_c)) * force[axis] +
                                  dot(truth.misalignment, force) + scatter.accel_noise_mps2 * random.gaussian();
        s.sensor[axis] = {600, gyro_mean, 600 * std::pow(scatter.gyro_noise_rps, 2), scatter.gyro_noise_rps};
        s.sensor[accel] = {600, accel_mean, 600 * std::pow(scatter.accel_noise_mps2, 2), scatter.accel_noise_mps2};
        run.segments.push_back(s);
      }
    }
    input.runs.push_back(std::move(run));
  }
  return input;
}

}  // namespace soak::calib::simulated
