// SPDX-License-Identifier: Apache-2.0
#include "nav/inertial/mechanization.h"

#include <cmath>

#include "base/units.h"
#include "calib/estimate/site.h"

namespace soak::nav {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void Mechanization::find_terms(double duration_s) {
  const Vector3d v = state_.velocity_mps + 0.5 * duration_s * acceleration_mps2_;
  const Geodetic& from = state_.position;
  const double sine = std::sin(from.latitude_rad + 0.5 * duration_s * v.y() / kSemiMajorAxis_m);
  const double cosine = std::sqrt(1.0 - sine * sine);
  const double height_m = from.height_m + 0.5 * duration_s * v.z();
  const double w2 = 1.0 - kEccentricitySquared * sine * sine;
  const double normal_m = kSemiMajorAxis_m / std::sqrt(w2);
  terms_.normal_m = normal_m + height_m;
  terms_.meridian_m = normal_m * (1.0 - kEccentricitySquared) / w2 + height_m;
  terms_.tan_latitude = sine / cosine;
  terms_.earth_rps = {0.0, base::kEarthRate_rps * cosine, base::kEarthRate_rps * sine};
  terms_.transport_rps = {-v.y() / terms_.meridian_m, v.x() / terms_.normal_m,
                          v.x() * terms_.tan_latitude / terms_.normal_m};
  terms_.gravity_mps2 = calib::normal_gravity_mps2(sine, height_m);
}

void Mechanization::step(const Increment& imu) {
  const double dt = imu.duration_s;
  find_terms(dt);

  // Rotation vector of the body, and change of velocity in the body axes of the interval's beginning.
  Vector3d turn = imu.angle_rad;
  Vector3d change = imu.velocity_mps + 0.5 * cross(imu.angle_rad, imu.velocity_mps);
  if (compensation_ == Compensation::two_sample && before_.duration_s > 0.0) {
    // 1/12 for intervals of one length; rates that change linearly over two unequal ones give this.
    const double share = dt * dt / (6.0 * before_.duration_s * (dt + before_.duration_s));
    turn += share * cross(before_.angle_rad, imu.angle_rad);
    change += share * (cross(before_.angle_rad, imu.velocity_mps) + cross(before_.velocity_mps, imu.angle_rad));
  }

  // v' = R f − (2 ω_ie + ω_el) × v + g; the level frame turns under the unit meanwhile.
  const Vector3d level_turn = dt * (terms_.earth_rps + terms_.transport_rps);
  const Matrix3d r = to_matrix(state_.body_to_level);
  const Vector3d push = r * change;
  const Vector3d v_mid = state_.velocity_mps + 0.5 * dt * acceleration_mps2_;
  const Vector3d gained = push - 0.5 * cross(level_turn, push) -
                          dt * cross(2.0 * terms_.earth_rps + terms_.transport_rps, v_mid) -
                          Vector3d(0.0, 0.0, dt * terms_.gravity_mps2);
  const Vector3d v_mean = state_.velocity_mps + 0.5 * gained;
  state_.velocity_mps += gained;
  acceleration_mps2_ = gained / dt;

  // Position with the mean velocity; 1/cos(latitude) by 1 + tan².
  const double secant = std::sqrt(1.0 + terms_.tan_latitude * terms_.tan_latitude);
  state_.position.latitude_rad += dt * v_mean.y() / terms_.meridian_m;
  state_.position.longitude_rad += dt * v_mean.x() / terms_.normal_m * secant;
  state_.position.height_m += dt * v_mean.z();

  // R' = R [ω_ib×] − [ω_il×] R.
  const Quaternion half = state_.body_to_level * rotation_of(0.5 * turn);
  terms_.body_to_level = to_matrix(half);
  terms_.force_mps2 = push / dt;
  state_.body_to_level = normalized(rotation_of(-level_turn) * state_.body_to_level * rotation_of(turn));
  before_ = imu;
}

}  // namespace soak::nav
