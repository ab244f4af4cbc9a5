// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

/// The Earth and what follows from a place on it: ellipsoid WGS 84 (NGA.STND.0036, 2014), local level frame with axes
/// east, north, up [AH05 §3.2]. Not for the poles: east is not defined there.
namespace soak::nav {

inline constexpr double kSemiMajorAxis_m = 6378137.0;
inline constexpr double kFlattening = 1.0 / 298.257223563;
inline constexpr double kEccentricitySquared = kFlattening * (2.0 - kFlattening);

/// A place relative to the ellipsoid.
struct Geodetic {
  double latitude_rad = 0.0;  ///< north positive
  double longitude_rad = 0.0;
  double height_m = 0.0;  ///< above the ellipsoid
};

/// Radii of curvature of the ellipsoid at a latitude.
struct Radii {
  double meridian_m = 0.0;  ///< M, along the meridian
  double normal_m = 0.0;    ///< N, along the prime vertical
};
[[nodiscard]] Radii radii_at(double latitude_rad);

/// Earth-centred, Earth-fixed coordinates in m.
[[nodiscard]] Eigen::Vector3d to_ecef(const Geodetic& place);
/// Back, by fixed-point iteration; heights from -10 km to 1000 km to better than 1 µm.
[[nodiscard]] Geodetic from_ecef(const Eigen::Vector3d& ecef_m);

/// Turns vectors from Earth-fixed into east, north, up at the place.
[[nodiscard]] Eigen::Matrix3d ecef_to_level(const Geodetic& place);

/// Where `place` lies from `origin`, in m along east, north, up of the origin.
[[nodiscard]] Eigen::Vector3d offset_m(const Geodetic& origin, const Geodetic& place);
/// The place a small way off, `level_m` along east, north, up: the error is that of neglecting the curvature, 1 mm in
/// 100 m of height.
[[nodiscard]] Geodetic moved(const Geodetic& place, const Eigen::Vector3d& level_m);

/// Rotation of the Earth in the local level frame, rad/s.
[[nodiscard]] Eigen::Vector3d earth_rate_rps(double latitude_rad);

}  // namespace soak::nav
