// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/alignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "../errors.h"
#include "base/units.h"
#include "nav/scenario/simulated_errors.h"
#include "nav/scenario/trajectory.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Matrix3d;
using Eigen::Vector3d;

const Geodetic kOrigin{51.08 * kRadPerDeg, -114.13 * kRadPerDeg, 1045.0};

TEST(Alignment, PitchAndRollComeFromGravity) {
  const Matrix3d r = matrix_of({1.0, 0.2, -0.4});
  const Euler found = leveled(r.transpose() * Vector3d(0.0, 0.0, 9.81));
  EXPECT_NEAR(found.pitch_rad, 0.2, 1e-14);
  EXPECT_NEAR(found.roll_rad, -0.4, 1e-14);
}

Drive drive_after(int rest_s, double gyro_white_dps = 0.02) {
  const auto maneuvers = town_drive(100, rest_s, 7);
  Drive drive = Trajectory(kOrigin, 2.5, maneuvers).drive(100, 25, {0.3, 1.0, 0.5});
  const UnitErrors errors{"", {0.2 * kRadPerDeg, 0.0, 100.0, gyro_white_dps * kRadPerDeg}, {0.02, 0.0, 100.0, 0.002}};
  add_errors(drive.imu, errors, {}, {}, 3);
  drive.gnss = simulated_fixes(drive.truth, 1, {}, 5);
  return drive;
}

/// The constants that drive_after() adds to the gyros: what the same seed gives without noise.
Vector3d gyro_biases_rps() {
  const UnitErrors only_bias{"", {0.2 * kRadPerDeg}, {0.02}};
  std::vector<ImuSample> at_rest(2);
  at_rest[1].t_s = 0.01;
  add_errors(at_rest, only_bias, {}, {}, 3);
  return at_rest[0].rate_rps;
}

/// The start's error of attitude in rad.
Vector3d attitude_error(const Drive& drive, const Start& start) {
  for (const TruthPoint& point : drive.truth) {
    if (point.t_s != start.t_s) continue;
    return vector_of(quaternion_of(to_matrix(start.state.body_to_level) * to_matrix(*point.body_to_level).transpose()));
  }
  return Vector3d::Constant(NAN);
}

TEST(Alignment, AStartAfterARestKnowsAttitudeAndGyroBiases) {
  const Drive drive = drive_after(20);
  const auto start = align(drive, {});
  ASSERT_TRUE(start);
  EXPECT_GT(start->t_s, 20.0);
  // The mean over 18 s knows a bias to 0.02 deg/sqrt(s) / sqrt(18 s); a tilt to the accelerometers' bias, 0.02/9.81 rad
  // (3 sigma), a heading to the velocity's 0.03 m/s in 3 m/s.
  const Vector3d error = attitude_error(drive, *start);
  EXPECT_LT(std::hypot(error.x(), error.y()), 0.01);
  EXPECT_LT(std::abs(error.z()), 0.04);
  EXPECT_LT(start->gyro_bias_rps.norm(), 0.03);
  EXPECT_LT((start->gyro_bias_rps - gyro_biases_rps()).norm(), 4.0 * 0.02 * kRadPerDeg / std::sqrt(18.0));
}

TEST(Alignment, TheRotationOfTheEarthIsNoBias) {
  const Drive drive = drive_after(20, 0.001);
  const auto start = align(drive, {});
  ASSERT_TRUE(start);
  // Noise of the mean, and the Earth's 4.6e-5 rad/s by a heading that the course of the first fix knows to 0.01 rad.
  const double noise_rps = 0.001 * kRadPerDeg / std::sqrt(18.0);
  const double tolerance_rps = 4.0 * std::hypot(noise_rps, 4.6e-5 * 0.01);
  ASSERT_LT(tolerance_rps, 0.3 * earth_rate_rps(kOrigin.latitude_rad).norm());
  EXPECT_LT((start->gyro_bias_rps - gyro_biases_rps()).norm(), tolerance_rps);
}

/// A drive that turns to the right while it speeds up, after a rest of `rest_s`; readings and fixes without errors.
struct Turn {
  Drive drive;
  TruthPoint antenna;  ///< where it starts
  TruthPoint unit;
  Start start;
};

Turn started_in_a_turn(int rest_s, const Vector3d& lever_m) {
  std::vector<Maneuver> maneuvers = {{8, 6.0, 2.4}, {20, 6.0}};
  if (rest_s > 0) maneuvers.insert(maneuvers.begin(), {rest_s});
  const Trajectory trajectory(kOrigin, 2.5, maneuvers);
  Turn turn;
  turn.drive = trajectory.drive(100, 25, lever_m);
  turn.drive.gnss = simulated_fixes(turn.drive.truth, 1, {1e-6, 1e-6, 1e-6, 1e-6}, 5);
  const auto start = align(turn.drive, {});
  if (!start) throw std::runtime_error(start.error().message);
  turn.start = *start;
  const Drive of_unit = trajectory.drive(100, 25, Vector3d::Zero());
  const auto at = std::ranges::find(of_unit.truth, start->t_s, &TruthPoint::t_s) - of_unit.truth.begin();
  turn.unit = of_unit.truth.at(static_cast<std::size_t>(at));
  turn.antenna = turn.drive.truth.at(static_cast<std::size_t>(at));
  return turn;
}

class AlignmentInATurn : public ::testing::TestWithParam<int> {};

TEST_P(AlignmentInATurn, HasVelocityAndHeadingOfTheUnitAndNotThoseOfTheAntenna) {
  for (const Vector3d& lever_m : {Vector3d(0.0, 3.0, 0.5), Vector3d(2.5, 1.5, 0.5), Vector3d(-2.5, -1.5, 1.0)}) {
    const Turn turn = started_in_a_turn(GetParam(), lever_m);
    // The unit of a vehicle that does not slide moves where its heading points; its antenna does not.
    const Vector3d beside_mps = turn.antenna.velocity_mps - turn.unit.velocity_mps;
    const double heading = euler_of(to_matrix(*turn.unit.body_to_level)).heading_rad;
    const double course = std::atan2(turn.antenna.velocity_mps.x(), turn.antenna.velocity_mps.y());
    ASSERT_GT(beside_mps.norm(), 0.7);
    ASSERT_GT(std::abs(course - heading), 0.15);
    // What stays is that the turn changes within the second over which it is read.
    EXPECT_LT((turn.start.state.velocity_mps - turn.unit.velocity_mps).norm(), 0.08 * beside_mps.norm());
    EXPECT_NEAR(euler_of(to_matrix(turn.start.state.body_to_level)).heading_rad, heading,
                0.08 * std::abs(course - heading));
  }
}

INSTANTIATE_TEST_SUITE_P(AfterARestAndWithoutOne, AlignmentInATurn, ::testing::Values(10, 0));

TEST(Alignment, PitchAndRollInATurnAreThoseOfTheUnitWhereverTheAntennaIs) {
  const auto tilt_error = [](const Vector3d& lever_m) {
    const Turn turn = started_in_a_turn(0, lever_m);
    const Vector3d error = attitude_error(turn.drive, turn.start);
    return std::hypot(error.x(), error.y());
  };
  // Without a lever arm: differences of velocities over a turn. 2.5 m beside the unit the antenna is drawn inwards by
  // ω² l, some 0.5 m/s² in this turn: 0.05 rad if it is taken for the unit.
  const double without_lever_rad = tilt_error(Vector3d::Zero());
  EXPECT_LT(without_lever_rad, 0.01);
  for (const Vector3d& lever_m : {Vector3d(2.5, 0.0, 0.5), Vector3d(-2.5, 1.5, 0.5), Vector3d(0.0, 3.0, 0.5)}) {
    EXPECT_LT(tilt_error(lever_m), 0.015) << lever_m.transpose();
  }
}

TEST(Alignment, AStartInMotionKnowsPitchAndRollRoughly) {
  const Drive drive = drive_after(0);
  const auto start = align(drive, {});
  ASSERT_TRUE(start);
  EXPECT_EQ(start->gyro_bias_rps, Vector3d::Zero());
  const Vector3d error = attitude_error(drive, *start);
  EXPECT_LT(std::hypot(error.x(), error.y()), 0.03);
  EXPECT_LT(std::abs(error.z()), 0.04);
}

TEST(Alignment, ADriveThatNeverMovesIsRefused) {
  Drive drive = drive_after(20);
  std::erase_if(drive.gnss, [](const GnssFix& fix) { return fix.velocity_mps.norm() > 1.0; });
  drive.name = "stuck";
  const auto start = align(drive, {});
  ASSERT_FALSE(start);
  EXPECT_EQ(start.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(start.error().where, "stuck");
}

}  // namespace
}  // namespace soak::nav
