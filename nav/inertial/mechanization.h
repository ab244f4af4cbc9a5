// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "nav/geometry/attitude.h"
#include "nav/geometry/earth.h"

namespace soak::nav {

/// What an inertial unit measured over an interval: integrals of its readings, in body axes.
struct Increment {
  double duration_s = 0.0;
  Eigen::Vector3d angle_rad = Eigen::Vector3d::Zero();     ///< ∫ω dt
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< ∫f dt, f the specific force
};

/// Position, velocity and attitude of a unit.
struct NavState {
  Geodetic position;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< over ground, along east, north, up
  Quaternion body_to_level;
};

/// What a step worked with, at the middle of its interval: the coefficients of the errors' equations.
struct StepTerms {
  Eigen::Matrix3d body_to_level = Eigen::Matrix3d::Identity();
  Eigen::Vector3d force_mps2 = Eigen::Vector3d::Zero();     ///< specific force, level axes
  Eigen::Vector3d earth_rps = Eigen::Vector3d::Zero();      ///< rotation of the Earth, level axes
  Eigen::Vector3d transport_rps = Eigen::Vector3d::Zero();  ///< of the level frame over the Earth, level axes
  double meridian_m = 0.0;                                  ///< M + h
  double normal_m = 0.0;                                    ///< N + h
  double tan_latitude = 0.0;
  double gravity_mps2 = 0.0;
};

/// How increments become a rotation and a change of velocity.
enum class Compensation {
  one_sample,  ///< the direction of the rate is constant within an interval
  two_sample,  ///< coning and sculling from this increment and the one before (Savage, J. Guidance 21 (1998) 19 and
               ///< 208)
};

/// Strapdown mechanization in the local level frame [AH05 eq. 3.6]:
///   latitude' = v_n/(M+h), longitude' = v_e/((N+h) cos(latitude)), h' = v_u,
///   v' = R f − (2 ω_ie + ω_el) × v + g,  R' = R [ω_ib×] − [(ω_ie + ω_el)×] R.
/// Rates of the level frame, Coriolis acceleration and gravity are taken in the middle of the interval, extrapolated
/// from the one before; the error of an interval is of third order in its length. For latitudes within ±89°.
class Mechanization {
 public:
  explicit Mechanization(const NavState& start, Compensation compensation = Compensation::two_sample)
      : state_(start), compensation_(compensation) {}

  /// Carries the state over one interval; duration > 0, intervals follow each other without gaps.
  void step(const Increment& imu);

  [[nodiscard]] const NavState& state() const { return state_; }
  /// Of the last step.
  [[nodiscard]] const StepTerms& terms() const { return terms_; }

  /// Puts another state in place of the present one (a filter's correction).
  void set_state(const NavState& state) { state_ = state; }

 private:
  void find_terms(double duration_s);

  NavState state_;
  Compensation compensation_;
  StepTerms terms_;
  Increment before_;                                             ///< the increment before
  Eigen::Vector3d acceleration_mps2_ = Eigen::Vector3d::Zero();  ///< change of the velocity in the step before
};

}  // namespace soak::nav
