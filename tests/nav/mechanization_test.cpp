// SPDX-License-Identifier: Apache-2.0
#include "nav/inertial/mechanization.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/units.h"
#include "calib/estimate/site.h"
#include "nav/inertial/drift.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kLatitude_rad = 51.08 * kRadPerDeg;  // Calgary

double gravity_mps2() { return calib::normal_gravity_mps2(std::sin(kLatitude_rad), 0.0); }

NavState at_rest() { return {{kLatitude_rad, -114.13 * kRadPerDeg, 0.0}, Vector3d::Zero(), {}}; }

/// What a unit reads that rests level, nose north, with constant errors.
Increment resting(double duration_s, const Vector3d& gyro_bias_rps, const Vector3d& accel_bias_mps2) {
  return {duration_s, duration_s * (earth_rate_rps(kLatitude_rad) + gyro_bias_rps),
          duration_s * (Vector3d(0.0, 0.0, gravity_mps2()) + accel_bias_mps2)};
}

Vector3d way_of_resting_m(double seconds, const Vector3d& gyro_bias_rps, const Vector3d& accel_bias_mps2,
                          const NavState& start = at_rest()) {
  Mechanization ins(start);
  for (int i = 0; i < std::lround(seconds * 100.0); ++i) ins.step(resting(0.01, gyro_bias_rps, accel_bias_mps2));
  return offset_m(at_rest().position, ins.state().position);
}

TEST(Mechanization, AUnitAtRestStays) {
  EXPECT_LT(way_of_resting_m(600.0, Vector3d::Zero(), Vector3d::Zero()).norm(), 1e-4);
}

TEST(Mechanization, AnAccelerometerBiasDriftsAsEquation6_5) {
  const Vector3d bias_mps2(0.3, 0.0, 0.0);  // of the MotionPak II over its temperatures [AH05 §6.4.1]
  // Next term of the Schuler oscillation, a t²/2 (1 − (g/R) t²/12): 1e-4 after 30 s, 5e-4 after 60 s.
  for (const double t : {30.0, 60.0}) {
    const double said_m = drift_of_accel_bias_m(0.3, t);
    EXPECT_NEAR(way_of_resting_m(t, Vector3d::Zero(), bias_mps2).x(), said_m, 1e-3 * said_m);
  }
  EXPECT_NEAR(drift_of_accel_bias_m(0.3, 30.0), 135.0, 1e-9);
}

TEST(Mechanization, AGyroBiasDriftsAsEquation6_6) {
  const double bias_rps = 0.5 * kRadPerDeg;
  EXPECT_NEAR(drift_of_gyro_bias_m(bias_rps, 30.0, 9.80665), 385.0, 0.5);
  EXPECT_NEAR(drift_of_gyro_bias_m(bias_rps, 60.0, 9.80665), 3081.0, 1.0);
  // A platform that has turned by θ = δω t pulls with g sin θ instead of g θ: integrated twice, θ²/20 less.
  for (const double t : {30.0, 60.0}) {
    const double said_m = drift_of_gyro_bias_m(bias_rps, t, gravity_mps2());
    const double angle = bias_rps * t;
    EXPECT_NEAR(way_of_resting_m(t, {0.0, bias_rps, 0.0}, Vector3d::Zero()).x(), said_m,
                (angle * angle / 20.0 + 1e-3) * said_m);
  }
}

TEST(Mechanization, AnErrorOfVelocitySwingsWithTheSchulerPeriod) {
  NavState start = at_rest();
  start.velocity_mps.y() = 0.1;
  // Without vertical instability: the height is put back each second. 2π sqrt(R/g) with R = M.
  Mechanization ins(start);
  double crossing_s = 0.0;
  double before_m = 0.0;
  for (int i = 1; i < 60000 && crossing_s == 0.0; ++i) {
    ins.step(resting(0.1, Vector3d::Zero(), Vector3d::Zero()));
    NavState held = ins.state();
    held.position.height_m = 0.0;
    held.velocity_mps.z() = 0.0;
    ins.set_state(held);
    const double north_m = (held.position.latitude_rad - kLatitude_rad) * radii_at(kLatitude_rad).meridian_m;
    if (i > 1000 && north_m <= 0.0 && before_m > 0.0) crossing_s = 0.1 * i;
    before_m = north_m;
  }
  const double half_period_s = pi * std::sqrt(radii_at(kLatitude_rad).meridian_m / gravity_mps2());
  // The Earth's rotation beats it (Foucault): cos(Ω sin φ t) keeps the sign, the crossing is moved below 1 %.
  EXPECT_NEAR(crossing_s, half_period_s, 0.01 * half_period_s);
}

/// Where a level unit ends that drives a circle of `radius_m` at `speed_mps` on a rotating Earth, from the east point,
/// northward (anticlockwise), relative to where it should: on a globe, way east counts for more longitude in the north
/// than in the south, so that the circle of level velocities ends π r² tan(latitude)/R west of its beginning.
Vector3d end_of_circle_m(double radius_m, double speed_mps, double dt, Compensation compensation) {
  const double rate_rps = speed_mps / radius_m;
  const double latitude_rad = kLatitude_rad;
  NavState start = at_rest();
  start.velocity_mps.y() = speed_mps;
  Mechanization ins(start, compensation);
  const Radii radii = radii_at(latitude_rad);
  const int steps = static_cast<int>(std::lround(2.0 * pi / rate_rps / dt));
  const double interval_s = 2.0 * pi / rate_rps / steps;
  const auto readings = [&](double t_s) {
    const double h = rate_rps * t_s;  // the nose turns from north to west
    const Matrix3d r = matrix_of({-h, 0.0, 0.0});
    const Vector3d v = speed_mps * Vector3d(-std::sin(h), std::cos(h), 0.0);
    const double lat = latitude_rad + radius_m * std::sin(h) / radii.meridian_m;
    const Vector3d earth = earth_rate_rps(lat);
    const Vector3d transport(-v.y() / radii_at(lat).meridian_m, v.x() / radii_at(lat).normal_m,
                             v.x() * std::tan(lat) / radii_at(lat).normal_m);
    const Vector3d a = speed_mps * rate_rps * Vector3d(-std::cos(h), -std::sin(h), 0.0);
    const Vector3d f =
        a + cross(2.0 * earth + transport, v) + Vector3d(0.0, 0.0, calib::normal_gravity_mps2(std::sin(lat), 0.0));
    const Vector3d w = earth + transport + Vector3d(0.0, 0.0, rate_rps);
    return std::pair<Vector3d, Vector3d>(r.transpose() * w, r.transpose() * f);
  };
  for (int i = 0; i < steps; ++i) {
    Increment sum{interval_s};
    // Simpson's rule
    for (const auto& [at, weight] : {std::pair(0.0, 1.0 / 6.0), std::pair(0.5, 4.0 / 6.0), std::pair(1.0, 1.0 / 6.0)}) {
      const auto [w, f] = readings((i + at) * interval_s);
      sum.angle_rad += weight * interval_s * w;
      sum.velocity_mps += weight * interval_s * f;
    }
    ins.step(sum);
  }
  const double west_m = pi * radius_m * radius_m * std::tan(latitude_rad) / radii.meridian_m;
  return offset_m(start.position, ins.state().position) + Vector3d(west_m, 0.0, 0.0);
}

TEST(Mechanization, ACircleEndsWhereTheGlobeSays) {
  EXPECT_LT(end_of_circle_m(200.0, 15.0, 0.01, Compensation::two_sample).norm(), 1e-3);
}

TEST(Mechanization, HalfTheStepLeavesAtMostAQuarterOfTheError) {
  const double coarse_m = end_of_circle_m(20.0, 10.0, 0.1, Compensation::two_sample).norm();
  const double fine_m = end_of_circle_m(20.0, 10.0, 0.05, Compensation::two_sample).norm();
  EXPECT_LT(fine_m, coarse_m / 3.5);
  EXPECT_GT(coarse_m, 1e-5);
}

/// Drift in rad/s about z of a unit whose axis goes round on a cone: half angle `cone_rad`, `hz` turns a second. Exact
/// attitude: exp of the vector cone (cos 2πft, sin 2πft, 0); its rate is that of a quaternion of constant angle.
double coning_drift_rps(double cone_rad, double hz, double dt, Compensation compensation) {
  const double w = 2.0 * pi * hz;
  NavState start{{0.0, 0.0, 0.0}, Vector3d::Zero(), rotation_of({cone_rad, 0.0, 0.0})};
  Mechanization ins(start, compensation);
  const int steps = static_cast<int>(std::lround(10.0 / dt));
  for (int i = 0; i < steps; ++i) {
    // ω = w (-sin(c) sin(wt), sin(c) cos(wt), cos(c) - 1) in body axes [Bortz 1971]; its integral in closed form.
    const double t0 = i * dt;
    const double t1 = t0 + dt;
    const Vector3d turned(std::sin(cone_rad) * (std::cos(w * t1) - std::cos(w * t0)),
                          std::sin(cone_rad) * (std::sin(w * t1) - std::sin(w * t0)),
                          w * (std::cos(cone_rad) - 1.0) * dt);
    // No specific force, and on the free-falling frame of a resting Earth nothing else turns: the Earth's own turn is
    // taken out below.
    ins.step({dt, turned, Vector3d::Zero()});
    NavState held = ins.state();
    held.position = start.position;
    held.velocity_mps = Vector3d::Zero();
    held.body_to_level = rotation_of(dt * earth_rate_rps(0.0)) * held.body_to_level;
    ins.set_state(held);
  }
  const Matrix3d truth =
      to_matrix(rotation_of(cone_rad * Vector3d(std::cos(w * steps * dt), std::sin(w * steps * dt), 0.0)));
  const Matrix3d error = to_matrix(ins.state().body_to_level) * truth.transpose();
  return vector_of(quaternion_of(error)).z() / (steps * dt);
}

TEST(Mechanization, ConingIsCorrectedAsItsClosedFormSays) {
  const double cone_rad = 0.01;
  const double hz = 5.0;
  const double dt = 0.01;
  const double w = 2.0 * pi * hz;
  // One sample: the mean of ½ α×ω is not seen, w (c²/2) (1 − sin(w dt)/(w dt)) about the cone's axis.
  const double expected_rps = 0.5 * w * cone_rad * cone_rad * (1.0 - std::sin(w * dt) / (w * dt));
  const double plain_rps = coning_drift_rps(cone_rad, hz, dt, Compensation::one_sample);
  EXPECT_NEAR(std::abs(plain_rps), expected_rps, 0.02 * expected_rps);
  // With the increment before: the remainder is of the fourth order in w dt (0.31): a tenth and less.
  EXPECT_LT(std::abs(coning_drift_rps(cone_rad, hz, dt, Compensation::two_sample)), 0.1 * expected_rps);
}

/// Mean acceleration in m/s² along z that sculling leaves: angle about x and force along y swing together, `hz`.
double sculling_mps2(double angle_rad, double force_mps2, double hz, double dt, Compensation compensation) {
  const double w = 2.0 * pi * hz;
  NavState start{{0.0, 0.0, 0.0}, Vector3d::Zero(), {}};
  Mechanization ins(start, compensation);
  const int steps = static_cast<int>(std::lround(2.0 / dt));
  double gained_mps = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double t0 = i * dt;
    const double t1 = t0 + dt;
    ins.step({dt,
              {angle_rad * (std::sin(w * t1) - std::sin(w * t0)), 0.0, 0.0},
              {0.0, force_mps2 * (std::cos(w * t0) - std::cos(w * t1)) / w, 0.0}});
    // what gravity took is given back; position and the Earth's turn as in coning
    NavState held = ins.state();
    gained_mps += held.velocity_mps.z() + ins.terms().gravity_mps2 * dt;
    held.position = start.position;
    held.velocity_mps = Vector3d::Zero();
    held.body_to_level = rotation_of(dt * earth_rate_rps(0.0)) * held.body_to_level;
    ins.set_state(held);
  }
  return gained_mps / (steps * dt);
}

TEST(Mechanization, ScullingIsCorrectedAsItsClosedFormSays) {
  // R f along z is sin(angle) f: the mean of θ sin(wt) · f sin(wt) is θ f / 2.
  const double angle_rad = 0.01;
  const double force_mps2 = 10.0;
  const double truth_mps2 = 0.5 * angle_rad * force_mps2;
  const double plain = sculling_mps2(angle_rad, force_mps2, 5.0, 0.01, Compensation::one_sample) - truth_mps2;
  const double corrected = sculling_mps2(angle_rad, force_mps2, 5.0, 0.01, Compensation::two_sample) - truth_mps2;
  EXPECT_GT(std::abs(plain), 1e-3 * truth_mps2);
  EXPECT_LT(std::abs(corrected), 0.1 * std::abs(plain));
}

}  // namespace
}  // namespace soak::nav
