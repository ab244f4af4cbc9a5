// SPDX-License-Identifier: Apache-2.0
#include "nav/geometry/earth.h"

#include <cmath>

#include "base/units.h"

namespace soak::nav {

Radii radii_at(double latitude_rad) {
  const double s = std::sin(latitude_rad);
  const double w2 = 1.0 - kEccentricitySquared * s * s;
  const double normal_m = kSemiMajorAxis_m / std::sqrt(w2);
  return {normal_m * (1.0 - kEccentricitySquared) / w2, normal_m};
}

Eigen::Vector3d to_ecef(const Geodetic& place) {
  const double normal_m = radii_at(place.latitude_rad).normal_m;
  const double across_m = (normal_m + place.height_m) * std::cos(place.latitude_rad);
  return {across_m * std::cos(place.longitude_rad), across_m * std::sin(place.longitude_rad),
          (normal_m * (1.0 - kEccentricitySquared) + place.height_m) * std::sin(place.latitude_rad)};
}

Geodetic from_ecef(const Eigen::Vector3d& ecef_m) {
  const double across_m = std::hypot(ecef_m.x(), ecef_m.y());
  Geodetic place{std::atan2(ecef_m.z(), across_m * (1.0 - kEccentricitySquared)), std::atan2(ecef_m.y(), ecef_m.x()),
                 0.0};
  // tan(latitude) = (z + e² N sin(latitude)) / across: each round gains a factor of about 1/e² = 150.
  for (int round = 0; round < 7; ++round) {
    const double s = std::sin(place.latitude_rad);
    const double normal_m = radii_at(place.latitude_rad).normal_m;
    place.latitude_rad = std::atan2(ecef_m.z() + kEccentricitySquared * normal_m * s, across_m);
  }
  const double s = std::sin(place.latitude_rad);
  const double normal_m = radii_at(place.latitude_rad).normal_m;
  place.height_m =
      across_m * std::cos(place.latitude_rad) + ecef_m.z() * s - normal_m * (1.0 - kEccentricitySquared * s * s);
  return place;
}

Eigen::Matrix3d ecef_to_level(const Geodetic& place) {
  const double sp = std::sin(place.latitude_rad);
  const double cp = std::cos(place.latitude_rad);
  const double sl = std::sin(place.longitude_rad);
  const double cl = std::cos(place.longitude_rad);
  Eigen::Matrix3d turn;
  turn << -sl, cl, 0.0, -sp * cl, -sp * sl, cp, cp * cl, cp * sl, sp;
  return turn;
}

Eigen::Vector3d offset_m(const Geodetic& origin, const Geodetic& place) {
  return ecef_to_level(origin) * (to_ecef(place) - to_ecef(origin));
}

Geodetic moved(const Geodetic& place, const Eigen::Vector3d& level_m) {
  const Radii radii = radii_at(place.latitude_rad);
  return {
      place.latitude_rad + level_m.y() / (radii.meridian_m + place.height_m),
      place.longitude_rad + level_m.x() / ((radii.normal_m + place.height_m) * std::cos(place.latitude_rad)),
      place.height_m + level_m.z(),
  };
}

Eigen::Vector3d earth_rate_rps(double latitude_rad) {
  return {0.0, base::kEarthRate_rps * std::cos(latitude_rad), base::kEarthRate_rps * std::sin(latitude_rad)};
}

}  // namespace soak::nav
