// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "calib/estimate/six_position.h"

namespace soak::calib::test {

/// A fixture with headings, on the turning Earth and out of level; the unit's three axes are alike.
struct Place {
  std::vector<std::pair<std::string, double>> stops;  ///< face up, azimuth of the next body axis
  double site_azimuth_deg = 25.0;
  double latitude_deg = 51.0;
  double north_rad = 0.0;  ///< lean of the true vertical
  double east_rad = 0.0;
  double accel_noise = 0.0;  ///< of segment means
  double gyro_noise = 0.0;
  std::map<std::string, std::array<double, 3>> face_tilt_rad = {};  ///< of the readings of x, y, z where horizontal
  std::uint64_t seed = 1;
};

inline constexpr double kPlaceGravity_mps2 = 9.81;
inline constexpr double kPlaceEarth_rps = 7.292115e-5;
inline constexpr std::array<double, 3> kPlaceMisalignment = {0.002, -0.003, 0.001};  ///< to x, y, z
inline constexpr std::array<double, 3> kPlaceGSensitivity = {3e-5, -2e-5, 4e-5};
inline constexpr double kPlaceEvenOrder = 5e-6;
inline constexpr double kPlaceGyroBias_rps = 0.01;
inline constexpr double kPlaceAccelBias_mps2 = 0.05;  ///< at 0 g
inline constexpr double kPlaceScale = 2000e-6;

using Matrix = std::array<std::array<double, 3>, 3>;

inline std::array<double, 3> times(const Matrix& m, const std::array<double, 3>& v) {
  std::array<double, 3> product{};
  for (std::size_t i = 0; i < 3; ++i) product[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return product;
}

/// Rows: the body axes in east, north, up of the fixture. The axis after the vertical one points at the heading; the
/// third makes the frame right-handed.
inline Matrix body_axes(const std::string& face, double heading_deg) {
  const auto vertical = static_cast<std::size_t>(face[1] - 'X');
  const double s = face[0] == '+' ? 1.0 : -1.0;
  const double psi = heading_deg * base::kRadPerDeg;
  Matrix axes{};
  axes[vertical] = {0.0, 0.0, s};
  axes[(vertical + 1) % 3] = {std::sin(psi), std::cos(psi), 0.0};
  axes[(vertical + 2) % 3] = {-s * std::cos(psi), s * std::sin(psi), 0.0};
  return axes;
}

/// Segments of one run over three plateaus, bias constant.
inline std::vector<Segment> segments_of(const Place& place) {
  const double length = std::hypot(1.0, place.north_rad, place.east_rad);
  const std::array<double, 3> up = {place.east_rad / length, place.north_rad / length, 1.0 / length};
  // North across the true vertical: (0, 1, 0) less its part along it.
  std::array<double, 3> north = {-up[1] * up[0], 1.0 - up[1] * up[1], -up[1] * up[2]};
  for (double& component : north) component /= std::sqrt(1.0 - up[1] * up[1]);
  const double phi = place.latitude_deg * base::kRadPerDeg;
  base::Random random(place.seed);
  std::vector<Segment> segments;
  double t_s = 0.0;
  for (int p = 0; p < 3; ++p, t_s += 1800.0) {
    for (const auto& [face, azimuth_deg] : place.stops) {
      const Matrix axes = body_axes(face, place.site_azimuth_deg + azimuth_deg);
      const auto u = times(axes, up);
      const auto n = times(axes, north);
      Segment s;
      s.position = *position_named(face);
      s.position->azimuth_deg = azimuth_deg;
      s.position->label += " " + std::to_string(azimuth_deg);
      s.key = {"run", "U", p, s.position->label, 0};
      s.plateau_c = s.temp_c = 20.0 * p;
      s.sensor_temp_c.fill(s.temp_c);
      s.t_start_s = t_s;
      s.t_end_s = (t_s += 600.0) - 10.0;
      for (std::size_t i = 0; i < 3; ++i) {
        double f = kPlaceGravity_mps2 * u[i];
        const auto tilts = place.face_tilt_rad.find(face);
        if (tilts != place.face_tilt_rad.end() && std::abs(u[i]) < 0.5) f += kPlaceGravity_mps2 * tilts->second[i];
        double accel = kPlaceAccelBias_mps2 + (1.0 + kPlaceScale) * f + kPlaceEvenOrder * f * f;
        double gyro = kPlaceGyroBias_rps + kPlaceEarth_rps * (std::sin(phi) * u[i] + std::cos(phi) * n[i]);
        for (std::size_t j = 0; j < 3; ++j) {
          accel += i == j ? 0.0 : kPlaceMisalignment[j] * kPlaceGravity_mps2 * u[j];
          gyro += kPlaceGSensitivity[j] * kPlaceGravity_mps2 * u[j];
        }
        const auto statistics = [&](double mean, double noise) {
          return SensorStatistics{600, mean + noise * random.gaussian(), 600.0 * noise * noise, noise};
        };
        s.sensor[i] = statistics(gyro, place.gyro_noise);
        s.sensor[i + 3] = statistics(accel, place.accel_noise);
      }
      segments.push_back(s);
    }
  }
  return segments;
}

inline Site site_of(const Place& place) {
  return {.latitude_deg = place.latitude_deg,
          .height_m = {},
          .azimuth_deg = place.site_azimuth_deg,
          .gravity_mps2 = kPlaceGravity_mps2};
}

inline SixPositionEstimate estimate(const Place& place) {
  return estimate_six_positions(segments_of(place), site_of(place), {});
}

/// Six faces whose headings tell north and east from everything that turns with the body.
inline Place six_headings() {
  return {.stops = {{"+X", 0.0}, {"-X", 90.0}, {"+Y", 30.0}, {"-Y", 200.0}, {"+Z", 120.0}, {"-Z", 250.0}}};
}

/// Every face at four headings.
inline Place every_quarter() {
  Place place;
  for (const std::string_view face : kSixPositionLabels) {
    for (const double azimuth_deg : {0.0, 90.0, 180.0, 270.0}) place.stops.emplace_back(face, azimuth_deg);
  }
  return place;
}

}  // namespace soak::calib::test
