// SPDX-License-Identifier: Apache-2.0
#include "nav/geometry/earth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "nav/geometry/attitude.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(Earth, RadiiAreThoseOfTheEllipsoid) {
  // NGA.STND.0036 table 3.5: polar radius of curvature a²/b = 6399593.6258 m; at the equator M = b²/a, N = a.
  const Radii pole = radii_at(90.0 * kRadPerDeg);
  EXPECT_NEAR(pole.meridian_m, 6399593.6258, 1e-3);
  EXPECT_NEAR(pole.normal_m, 6399593.6258, 1e-3);
  const double b_m = 6356752.3142;
  EXPECT_NEAR(radii_at(0.0).meridian_m, b_m * b_m / 6378137.0, 1e-3);
  EXPECT_NEAR(radii_at(0.0).normal_m, 6378137.0, 1e-9);
}

TEST(Earth, PlacesComeBackFromEarthFixedCoordinates) {
  for (const double latitude_deg : {-89.0, -33.3, 0.0, 12.0, 51.08, 88.0}) {
    for (const double height_m : {-400.0, 0.0, 1601.4, 20000.0}) {
      const Geodetic place{latitude_deg * kRadPerDeg, -114.13 * kRadPerDeg, height_m};
      const Geodetic back = from_ecef(to_ecef(place));
      EXPECT_NEAR(back.latitude_rad, place.latitude_rad, 1e-14);
      EXPECT_NEAR(back.longitude_rad, place.longitude_rad, 1e-14);
      EXPECT_NEAR(back.height_m, height_m, 1e-6);
    }
  }
}

TEST(Earth, EarthFixedCoordinatesLieOnTheEllipsoid) {
  const Vector3d p = to_ecef({51.08 * kRadPerDeg, -114.13 * kRadPerDeg, 0.0});
  const double b_m = 6356752.314245;
  EXPECT_NEAR((p.x() * p.x() + p.y() * p.y()) / std::pow(6378137.0, 2) + p.z() * p.z() / (b_m * b_m), 1.0, 1e-12);
}

TEST(Earth, AWayMovedIsTheOffsetThatComesBack) {
  const Geodetic origin{40.1 * kRadPerDeg, -105.1 * kRadPerDeg, 1600.0};
  const Vector3d way_m(70.0, -40.0, 5.0);
  // The curvature lowers what is 80 m away by 80²/2R = 0.5 mm.
  EXPECT_LT((offset_m(origin, moved(origin, way_m)) - way_m).norm(), 1e-3);
}

TEST(Earth, LevelAxesAreEastNorthUp) {
  const Matrix3d turn = ecef_to_level({0.0, 0.0, 0.0});
  // Where the equator meets the zero meridian, x points up, y east and z north.
  EXPECT_LT((turn * Vector3d(1.0, 2.0, 3.0) - Vector3d(2.0, 3.0, 1.0)).norm(), 1e-15);
  EXPECT_LT((earth_rate_rps(0.7) - ecef_to_level({0.7, 1.0, 0.0}) * Vector3d(0.0, 0.0, base::kEarthRate_rps)).norm(),
            1e-19);
}

TEST(Attitude, AnglesQuaternionAndMatrixSayTheSame) {
  for (const double heading : {-3.0, -0.5, 0.0, 2.0}) {
    for (const double pitch : {-1.2, 0.0, 0.3}) {
      for (const double roll : {-2.5, 0.1, 3.0}) {
        const Matrix3d r = matrix_of({heading, pitch, roll});
        EXPECT_LT((r * r.transpose() - Matrix3d::Identity()).norm(), 1e-14);
        EXPECT_LT((to_matrix(quaternion_of(r)) - r).norm(), 1e-14);
        const Euler back = euler_of(r);
        EXPECT_NEAR(back.heading_rad, heading, 1e-13);
        EXPECT_NEAR(back.pitch_rad, pitch, 1e-13);
        EXPECT_NEAR(back.roll_rad, roll, 1e-13);
      }
    }
  }
}

TEST(Attitude, NoseAndRightSidePointWhereTheAnglesSay) {
  // Heading east, nose 30° up: the forward axis is (cos 30°, 0, sin 30°).
  const Matrix3d climbing = matrix_of({90.0 * kRadPerDeg, 30.0 * kRadPerDeg, 0.0});
  EXPECT_LT((climbing.col(1) - Vector3d(std::sqrt(0.75), 0.0, 0.5)).norm(), 1e-15);
  // Right side down by 20°: the right axis of a unit that heads north is (cos 20°, 0, -sin 20°).
  const Matrix3d leaning = matrix_of({0.0, 0.0, 20.0 * kRadPerDeg});
  EXPECT_LT((leaning.col(0) - Vector3d(std::cos(20.0 * kRadPerDeg), 0.0, -std::sin(20.0 * kRadPerDeg))).norm(), 1e-15);
}

TEST(Attitude, ARotationVectorTurnsByItsLength) {
  const Vector3d axis = Vector3d(1.0, -2.0, 2.0) / 3.0;
  for (const double angle : {1e-9, 1e-3, 0.019, 0.021, 0.5, 3.0}) {
    const Matrix3d r = to_matrix(rotation_of(angle * axis));
    // Rodrigues: trace = 1 + 2 cos(angle); the axis stays.
    EXPECT_NEAR(r.trace(), 1.0 + 2.0 * std::cos(angle), 1e-14);
    EXPECT_LT((r * axis - axis).norm(), 1e-15);
    EXPECT_LT((vector_of(rotation_of(angle * axis)) - angle * axis).norm(), 1e-14);
    EXPECT_LT(
        (r - (Matrix3d::Identity() + std::sin(angle) * skew(axis) + (1.0 - std::cos(angle)) * skew(axis) * skew(axis)))
            .norm(),
        1e-14);
  }
}

}  // namespace
}  // namespace soak::nav
