// SPDX-License-Identifier: Apache-2.0
#include "nav/scenario/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "calib/estimate/site.h"
#include "nav/inertial/mechanization.h"
#include "nav/scenario/simulated_errors.h"
#include "nav/scenario/spline.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Vector3d;

const Geodetic kOrigin{51.08 * kRadPerDeg, -114.13 * kRadPerDeg, 1045.0};

TEST(MonotoneSpline, StopsStayStopsAndTheSlopeIsTheDerivative) {
  const MonotoneSpline spline({0.0, 5.0, 12.0, 20.0, 30.0, 31.0}, {0.0, 0.0, 15.0, 15.0, 0.0, 0.0});
  for (double t = 0.0; t < 31.0; t += 0.37) {
    const auto [value, slope] = spline.at(t);
    EXPECT_GE(value, 0.0);
    EXPECT_LE(value, 15.0);
    EXPECT_NEAR(slope, (spline.at(t + 1e-5).value - spline.at(t - 1e-5).value) / 2e-5, 1e-5);
  }
  EXPECT_EQ(spline.at(3.3).value, 0.0);
  EXPECT_EQ(spline.at(15.0).value, 15.0);
  EXPECT_EQ(spline.at(30.5).slope, 0.0);
}

TEST(Trajectory, AttractionAndTheEarthsRotationAreNormalGravity) {
  for (const double latitude_deg : {-70.0, -30.0, 0.0, 20.0, 45.0, 60.0, 85.0}) {
    const Geodetic place{latitude_deg * kRadPerDeg, 0.4, 1500.0};
    const Vector3d p = to_ecef(place);
    const double turn2 = base::kEarthRate_rps * base::kEarthRate_rps;
    const Vector3d gravity = ecef_to_level(place) * (attraction_mps2(p) + turn2 * Vector3d(p.x(), p.y(), 0.0));
    // Left out: harmonics from J6 on, 6e-9 of gravity; the second order of the height and the tilt of the vertical with
    // it, 1.1e-8 rad/m at most (0.16 mGal at 1500 m).
    EXPECT_NEAR(-gravity.z(), calib::normal_gravity_mps2(std::sin(place.latitude_rad), place.height_m), 2e-6);
    EXPECT_NEAR(gravity.x(), 0.0, 1e-8);
    EXPECT_NEAR(gravity.y(), 0.0, 1.5e-5);
  }
}

TEST(SimulatedErrors, NoiseOfABandIsThatOfTheMakersTable) {
  // Readings at twice the bandwidth hold all noise of the band: 6 mV of 2.5 V at 75 deg/s, 5 mV of 2.5 V at 1.5 g.
  struct Band {
    double rate_hz;
    Vector3d ImuSample::* reading;
    double rms;
  };
  const Band bands[] = {{60.0, &ImuSample::rate_rps, 0.18 * kRadPerDeg},
                        {40.0, &ImuSample::force_mps2, 0.003 * base::kStandardGravity_mps2}};
  UnitErrors only_noise{"", {}, {}};
  only_noise.gyro.white = motionpak2().gyro.white;
  only_noise.accel.white = motionpak2().accel.white;
  for (const Band& band : bands) {
    std::vector<ImuSample> samples(20000);
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i].t_s = static_cast<double>(i) / band.rate_hz;
    add_errors(samples, only_noise, {}, {}, 4);
    double squares = 0.0;
    for (const ImuSample& sample : samples) squares += (sample.*band.reading).squaredNorm();
    // 60,000 numbers know their root mean square to 0.3 %.
    EXPECT_NEAR(std::sqrt(squares / (3.0 * static_cast<double>(samples.size()))), band.rms, 0.015 * band.rms);
  }
}

TEST(Trajectory, TheMechanizationFollowsADriveOfTenMinutes) {
  const auto maneuvers = town_drive(600, 10, 1);
  const Trajectory trajectory(kOrigin, 0.4, maneuvers);
  const Drive drive = trajectory.drive(100, 100, Vector3d::Zero());
  ASSERT_TRUE(validate(drive));
  Mechanization ins(
      {drive.truth.front().position, drive.truth.front().velocity_mps, *drive.truth.front().body_to_level});
  double way_m = 0.0;
  double turned_rad = 0.0;
  double worst_m = 0.0;
  for (std::size_t i = 0; i < drive.imu.size(); ++i) {
    ins.step({0.01, 0.01 * drive.imu[i].rate_rps, 0.01 * drive.imu[i].force_mps2});
    way_m += 0.01 * ins.state().velocity_mps.norm();
    turned_rad += 0.01 * std::abs(drive.imu[i].rate_rps.z());
    if ((i + 1) % 100 != 0) continue;
    const TruthPoint& truth = drive.truth[(i + 1) / 100];
    worst_m = std::max(worst_m, offset_m(truth.position, ins.state().position).norm());
    const Eigen::Matrix3d error = to_matrix(ins.state().body_to_level) * to_matrix(*truth.body_to_level).transpose();
    EXPECT_LT(vector_of(quaternion_of(error)).norm(), 1e-6);
  }
  EXPECT_GT(way_m, 3000.0);
  EXPECT_GT(turned_rad, 10.0);
  // The plumb line's tilt with height, 1.1e-5 m/s², is not in the mechanization; unbounded it would be 2 m in 600 s,
  // and Schuler's pendulum holds it to half of that. In height errors grow by the anti-spring, doubling each 390 s.
  EXPECT_LT(worst_m, 2.5);
}

TEST(Trajectory, TheAntennaIsWhereTheLeverPutsIt) {
  const std::vector<Maneuver> maneuvers = {{5, 10.0}, {10, 10.0, 90.0 * kRadPerDeg}};
  const Vector3d lever_m(1.0, 2.0, 0.5);
  const Drive at_unit = Trajectory(kOrigin, 0.0, maneuvers).drive(100, 1, Vector3d::Zero());
  const Drive at_antenna = Trajectory(kOrigin, 0.0, maneuvers).drive(100, 1, lever_m);
  for (std::size_t i = 1; i + 1 < at_antenna.truth.size(); i += 97) {
    const TruthPoint& unit = at_unit.truth[i];
    const TruthPoint& antenna = at_antenna.truth[i];
    EXPECT_LT((offset_m(unit.position, antenna.position) - to_matrix(*unit.body_to_level) * lever_m).norm(), 1e-6);
    // Velocity against the difference of positions, whose error is the third derivative, 1e-4/6 times a few m/s³.
    const Vector3d moved_mps = offset_m(at_antenna.truth[i - 1].position, at_antenna.truth[i + 1].position) / 0.02;
    EXPECT_LT((moved_mps - antenna.velocity_mps).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace soak::nav
