// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/alignment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace soak::nav {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRestSpeed_mps = 0.3;
/// A rest ends so long before the first fix that shows movement.
constexpr double kRestMargin_s = 1.0;
/// The specific force at the start in motion is a mean over so long to both sides.
constexpr double kHalfWindow_s = 0.5;
double speed_mps(const GnssFix& fix) { return std::hypot(fix.velocity_mps.x(), fix.velocity_mps.y()); }

struct Means {
  Vector3d rate_rps = Vector3d::Zero();
  Vector3d force_mps2 = Vector3d::Zero();
  double samples = 0.0;
};

Means means_between(const std::vector<ImuSample>& imu, double from_s, double to_s) {
  Means means;
  for (auto sample = std::ranges::upper_bound(imu, from_s, {}, &ImuSample::t_s);
       sample != imu.end() && sample->t_s <= to_s; ++sample) {
    means.rate_rps += sample->rate_rps;
    means.force_mps2 += sample->force_mps2;
    means.samples += 1.0;
  }
  means.rate_rps /= std::max(means.samples, 1.0);
  means.force_mps2 /= std::max(means.samples, 1.0);
  return means;
}

/// Attitude but for the heading, at `until_s`, carried there by the gyros from a rest.
Matrix3d carried(const Drive& drive, const Means& rest, double from_s, double until_s) {
  Quaternion attitude = quaternion_of(matrix_of(leveled(rest.force_mps2)));
  ImuFeed feed(drive.imu, from_s);
  while (const auto piece = feed.next(until_s)) {
    attitude = normalized(attitude * rotation_of(piece->duration_s * (piece->sample->rate_rps - rest.rate_rps)));
  }
  return to_matrix(attitude);
}

/// By how much the antenna is accelerated more than the unit, ω' × l + ω × (ω × l), body axes.
Vector3d beside_mps2(const Drive& drive, double t_s) {
  const Vector3d rate_rps = means_between(drive.imu, t_s - kHalfWindow_s, t_s + kHalfWindow_s).rate_rps;
  const Means before = means_between(drive.imu, t_s - kHalfWindow_s, t_s);
  const Means after = means_between(drive.imu, t_s, t_s + kHalfWindow_s);
  Vector3d faster_rps2 = Vector3d::Zero();
  if (before.samples > 0.0 && after.samples > 0.0) faster_rps2 = (after.rate_rps - before.rate_rps) / kHalfWindow_s;
  return cross(faster_rps2, drive.lever_arm_m) + cross(rate_rps, cross(rate_rps, drive.lever_arm_m));
}

/// Pitch and roll in motion. The level force, seen from the heading, has its own "pitch" and "roll": those of a unit
/// that reads it are the differences.
Euler leveled_in_motion(const Drive& drive, std::size_t fix, double heading_rad) {
  const GnssFix& at = drive.gnss[fix];
  const GnssFix& next = drive.gnss[std::min(fix + 1, drive.gnss.size() - 1)];
  const GnssFix& before = drive.gnss[fix > 0 ? fix - 1 : 0];
  const double between_s = next.t_s - before.t_s;
  Vector3d acceleration = Vector3d::Zero();
  if (between_s > 0.0) acceleration = (next.velocity_mps - before.velocity_mps) / between_s;
  const Means means = means_between(drive.imu, at.t_s - kHalfWindow_s, at.t_s + kHalfWindow_s);
  const Matrix3d level_to_heading = matrix_of({heading_rad, 0.0, 0.0}).transpose();
  const Vector3d seen =
      level_to_heading * (acceleration + Vector3d(0.0, 0.0, base::kStandardGravity_mps2)) - beside_mps2(drive, at.t_s);
  const Euler read = leveled(means.force_mps2);
  const Euler level = leveled(seen);
  return {heading_rad, read.pitch_rad - level.pitch_rad, read.roll_rad - level.roll_rad};
}

}  // namespace

double end_of_rest_s(const Drive& drive) {
  double end_s = drive.imu.front().t_s;
  for (const GnssFix& fix : drive.gnss) {
    if (speed_mps(fix) > kRestSpeed_mps) break;
    end_s = std::max(end_s, fix.t_s - kRestMargin_s);
  }
  return end_s;
}

Euler leveled(const Vector3d& f) {
  return {0.0, std::atan2(f.y(), std::hypot(f.x(), f.z())), std::atan2(-f.x(), f.z())};
}

base::Result<Start> align(const Drive& drive, const AlignmentOptions& options) {
  const auto first = std::ranges::find_if(drive.gnss, [&](const GnssFix& fix) {
    return speed_mps(fix) >= options.least_speed_mps && fix.t_s >= drive.imu.front().t_s;
  });
  if (first == drive.gnss.end() || first->t_s >= drive.imu.back().t_s) {
    return base::bad_input(
        fmt::format("no fix is faster than {} m/s while the unit was read: the heading stays unknown",
                    options.least_speed_mps),
        drive.name);
  }
  Start start;
  start.t_s = first->t_s;
  Euler angles;
  const double rest_s = end_of_rest_s(drive);
  const bool has_rest = rest_s - drive.imu.front().t_s >= options.least_rest_s;
  const Means rest = has_rest ? means_between(drive.imu, drive.imu.front().t_s, rest_s) : Means{};
  // In a turn the antenna moves beside the unit, by ω × lever arm: its course is not the heading.
  const Means now = means_between(drive.imu, start.t_s - kHalfWindow_s, start.t_s + kHalfWindow_s);
  const Vector3d beside_mps = cross(now.rate_rps - rest.rate_rps, drive.lever_arm_m);
  const double course_rad = std::atan2(first->velocity_mps.x(), first->velocity_mps.y());
  const double heading_rad = course_rad - std::asin(std::clamp(beside_mps.x() / speed_mps(*first), -1.0, 1.0));
  if (has_rest) {
    angles = euler_of(carried(drive, rest, rest_s, start.t_s));
    // The gyros tell how far the vehicle has turned since the rest: its course then gives the heading at rest.
    Euler at_rest = leveled(rest.force_mps2);
    at_rest.heading_rad = heading_rad - angles.heading_rad;
    start.gyro_bias_rps = rest.rate_rps - matrix_of(at_rest).transpose() * earth_rate_rps(first->position.latitude_rad);
  } else {
    angles = leveled_in_motion(drive, static_cast<std::size_t>(first - drive.gnss.begin()), heading_rad);
  }
  angles.heading_rad = heading_rad;
  const Matrix3d r = matrix_of(angles);
  start.state.body_to_level = quaternion_of(r);
  start.state.position = moved(first->position, -(r * drive.lever_arm_m));
  start.state.velocity_mps = first->velocity_mps - r * beside_mps;
  start.position_sigma_m = first->position_sigma_m;
  start.velocity_sigma_mps = first->velocity_sigma_mps;
  const double tilt_rad = (has_rest ? 1.0 : 3.0) * options.tilt_sigma_rad;
  start.attitude_sigma_rad = {tilt_rad, tilt_rad, options.heading_sigma_rad};
  return start;
}

}  // namespace soak::nav
