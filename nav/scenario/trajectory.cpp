// SPDX-License-Identifier: Apache-2.0
#include "nav/scenario/trajectory.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/units.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// One of the quantities of the maneuvers over time.
template <class Next>
MonotoneSpline spline_of(std::span<const Maneuver> maneuvers, double first, Next next) {
  std::vector<double> t_s = {0.0};
  std::vector<double> values = {first};
  for (const Maneuver& maneuver : maneuvers) {
    t_s.push_back(t_s.back() + maneuver.duration_s);
    values.push_back(next(values.back(), maneuver));
  }
  return {std::move(t_s), std::move(values)};
}

}  // namespace

std::vector<Maneuver> town_drive(int duration_s, int rest_s, std::uint64_t seed) {
  base::Random random(seed);
  const auto seconds = [&](double low, double high) {
    return static_cast<int>(std::lround(random.uniform(low, high)));
  };
  std::vector<Maneuver> maneuvers;
  int total_s = 0;
  const auto add = [&](const Maneuver& maneuver) {
    maneuvers.push_back(maneuver);
    total_s += maneuver.duration_s;
  };
  if (rest_s > 0) add({rest_s});
  while (total_s < duration_s) {
    const double cruise_mps = random.uniform(8.0, 16.0);
    const double slope_rad = random.uniform(-3.0, 3.0) * kRadPerDeg;
    add({seconds(6.0, 10.0), cruise_mps});
    add({seconds(5.0, 25.0), cruise_mps, 0.0, slope_rad});
    add({seconds(4.0, 8.0), cruise_mps});
    const double turn_mps = random.uniform(5.0, 8.0);
    add({seconds(4.0, 6.0), turn_mps});
    const double side = random.uniform() < 0.5 ? -1.0 : 1.0;
    add({seconds(6.0, 9.0), turn_mps, side * random.uniform(60.0, 100.0) * kRadPerDeg});
    if (random.uniform() > 0.35) continue;
    add({seconds(4.0, 6.0), 0.0});
    add({seconds(5.0, 15.0), 0.0});
  }
  return maneuvers;
}

Vector3d attraction_mps2(const Vector3d& p) {
  // WGS 84: GM, and the zonal harmonics of the normal field (NGA.STND.0036 tables 3.1, 3.6: J2, J4 = -C40 sqrt(9)).
  constexpr double kGm = 3.986004418e14;
  constexpr double kJ2 = 1.082629821e-3;
  constexpr double kJ4 = -2.37091222e-6;
  const double r = p.norm();
  const double q2 = kSemiMajorAxis_m * kSemiMajorAxis_m / (r * r);
  const double s2 = p.z() * p.z() / (r * r);
  const double j2 = 1.5 * kJ2 * q2;
  const double j4 = 0.625 * kJ4 * q2 * q2;
  const double across = 1.0 + j2 * (1.0 - 5.0 * s2) - j4 * (3.0 - 42.0 * s2 + 63.0 * s2 * s2);
  const double along = 1.0 + j2 * (3.0 - 5.0 * s2) - j4 * (15.0 - 70.0 * s2 + 63.0 * s2 * s2);
  return -kGm / (r * r * r) * Vector3d(p.x() * across, p.y() * across, p.z() * along);
}

Trajectory::Trajectory(const Geodetic& origin, double heading_rad, std::span<const Maneuver> maneuvers)
    : duration_s_(0.0),
      origin_ecef_m_(to_ecef(origin)),
      plane_to_ecef_(ecef_to_level(origin).transpose()),
      speed_(spline_of(maneuvers, 0.0, [](double, const Maneuver& m) { return m.speed_mps; })),
      course_(spline_of(maneuvers, heading_rad, [](double course, const Maneuver& m) { return course + m.turn_rad; })),
      slope_(spline_of(maneuvers, 0.0, [](double, const Maneuver& m) { return m.slope_rad; })) {
  for (const Maneuver& maneuver : maneuvers) duration_s_ += maneuver.duration_s;
}

Trajectory::Motion Trajectory::at(double t_s) const {
  const auto [speed, speeding] = speed_.at(t_s);
  const auto [course, turning] = course_.at(t_s);
  const auto [slope, tipping] = slope_.at(t_s);
  const double sc = std::sin(course);
  const double cc = std::cos(course);
  const double ss = std::sin(slope);
  const double cs = std::cos(slope);
  const Vector3d ahead(cs * sc, cs * cc, ss);
  const Vector3d ahead_changes =
      turning * Vector3d(cs * cc, -cs * sc, 0.0) + tipping * Vector3d(-ss * sc, -ss * cc, cs);
  // R = Rz(-course) Rx(slope): the course turns about the plane's vertical, the slope about the right axis.
  return {speed * ahead, speeding * ahead + speed * ahead_changes, matrix_of({course, slope, 0.0}),
          Vector3d(tipping, -turning * ss, -turning * cs)};
}

void Trajectory::read(const Motion& motion, const Vector3d& plane_m, ImuSample& sample) const {
  const Vector3d earth(0.0, 0.0, base::kEarthRate_rps);
  const Vector3d p = origin_ecef_m_ + plane_to_ecef_ * plane_m;
  const Vector3d v = plane_to_ecef_ * motion.velocity_mps;
  const Vector3d a = plane_to_ecef_ * motion.acceleration_mps2;
  // Newton in inertial space: f = a + 2 Ω × v + Ω × (Ω × p) − attraction
  const Vector3d f = a + 2.0 * cross(earth, v) + cross(earth, cross(earth, p)) - attraction_mps2(p);
  const Matrix3d ecef_to_body = (plane_to_ecef_ * motion.body_to_plane).transpose();
  sample.force_mps2 = ecef_to_body * f;
  sample.rate_rps = motion.turn_rps + ecef_to_body * earth;
}

TruthPoint Trajectory::truth_of(double t_s, const Vector3d& plane_m, const Vector3d& lever_m) const {
  const Motion motion = at(t_s);
  const Geodetic unit = from_ecef(origin_ecef_m_ + plane_to_ecef_ * plane_m);
  const Matrix3d plane_to_level = ecef_to_level(unit) * plane_to_ecef_;
  const Vector3d antenna_m = plane_m + motion.body_to_plane * lever_m;
  const Vector3d antenna_mps = motion.velocity_mps + motion.body_to_plane * cross(motion.turn_rps, lever_m);
  return {t_s, from_ecef(origin_ecef_m_ + plane_to_ecef_ * antenna_m), plane_to_level * antenna_mps,
          quaternion_of(plane_to_level * motion.body_to_plane)};
}

Drive Trajectory::drive(int rate_hz, int truth_every, const Vector3d& lever_arm_m) const {
  Drive drive;
  drive.lever_arm_m = lever_arm_m;
  const double dt = 1.0 / rate_hz;
  const int samples = static_cast<int>(std::lround(duration_s_)) * rate_hz;
  Vector3d plane_m = Vector3d::Zero();
  Motion begin = at(0.0);
  drive.truth.push_back(truth_of(0.0, plane_m, lever_arm_m));
  for (int i = 1; i <= samples; ++i) {
    const double t_s = i * dt;
    const Motion middle = at(t_s - 0.5 * dt);
    const Motion end = at(t_s);
    // Position by Simpson's rule, in the middle by the parabola through the three velocities.
    const Vector3d middle_m =
        plane_m + dt / 24.0 * (5.0 * begin.velocity_mps + 8.0 * middle.velocity_mps - end.velocity_mps);
    const Vector3d end_m = plane_m + dt / 6.0 * (begin.velocity_mps + 4.0 * middle.velocity_mps + end.velocity_mps);
    ImuSample readings[3];
    read(begin, plane_m, readings[0]);
    read(middle, middle_m, readings[1]);
    read(end, end_m, readings[2]);
    ImuSample mean;
    mean.t_s = t_s;
    mean.rate_rps = (readings[0].rate_rps + 4.0 * readings[1].rate_rps + readings[2].rate_rps) / 6.0;
    mean.force_mps2 = (readings[0].force_mps2 + 4.0 * readings[1].force_mps2 + readings[2].force_mps2) / 6.0;
    drive.imu.push_back(mean);
    plane_m = end_m;
    begin = end;
    if (i % truth_every == 0) drive.truth.push_back(truth_of(t_s, plane_m, lever_arm_m));
  }
  return drive;
}

}  // namespace soak::nav
