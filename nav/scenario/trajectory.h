// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "nav/drive/drive.h"
#include "nav/scenario/spline.h"

/// Drives that never were, without the filter's equations: speed, course and slope are splines of time in a plane that
/// touches the Earth at the origin; what a unit reads follows from their derivatives, Newton's law in Earth-fixed axes
/// and the Earth's field of attraction.
namespace soak::nav {

/// A piece of a drive. Whole seconds, so that the knots of the splines are samples.
struct Maneuver {
  int duration_s = 1;
  double speed_mps = 0.0;  ///< at its end
  double turn_rad = 0.0;   ///< change of the course meanwhile, to the right
  double slope_rad = 0.0;  ///< upwards, at its end
};

/// Straights, turns of up to 100° to both sides, slopes up to 3° and stops, after a rest of `rest_s` (a whole number).
/// The seed decides.
[[nodiscard]] std::vector<Maneuver> town_drive(int duration_s, int rest_s, std::uint64_t seed);

/// Attraction of the Earth in m/s², Earth-fixed axes, of its mass and the harmonics J2 and J4 (WGS 84). No part of the
/// Earth's rotation.
[[nodiscard]] Eigen::Vector3d attraction_mps2(const Eigen::Vector3d& ecef_m);

/// The vehicle goes where its nose points and does not lean.
class Trajectory {
 public:
  /// At least one maneuver.
  Trajectory(const Geodetic& origin, double heading_rad, std::span<const Maneuver> maneuvers);

  [[nodiscard]] double duration_s() const { return duration_s_; }

  /// What a unit without errors reads on the way, and the antenna's truth at every `truth_every`-th sample, from time
  /// 0. Samples are means over their interval (Simpson's rule on the splines).
  [[nodiscard]] Drive drive(int rate_hz, int truth_every, const Eigen::Vector3d& lever_arm_m) const;

 private:
  /// Where the vehicle is and how it moves; tangent-plane axes (east, north, up of the origin).
  struct Motion {
    Eigen::Vector3d velocity_mps;
    Eigen::Vector3d acceleration_mps2;
    Eigen::Matrix3d body_to_plane;
    Eigen::Vector3d turn_rps;  ///< of the body relative to the Earth, body axes
  };
  [[nodiscard]] Motion at(double t_s) const;
  /// Specific force and rate relative to inertial space, body axes.
  void read(const Motion& motion, const Eigen::Vector3d& plane_m, ImuSample& sample) const;
  [[nodiscard]] TruthPoint truth_of(double t_s, const Eigen::Vector3d& plane_m, const Eigen::Vector3d& lever_m) const;

  double duration_s_;
  Eigen::Vector3d origin_ecef_m_;
  Eigen::Matrix3d plane_to_ecef_;
  MonotoneSpline speed_;
  MonotoneSpline course_;
  MonotoneSpline slope_;
};

}  // namespace soak::nav
