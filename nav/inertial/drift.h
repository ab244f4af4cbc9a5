// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Position errors of free-inertial navigation from a bias that nobody took away.
namespace soak::nav {

/// δp = δb t²/2 in m: a horizontal accelerometer's bias in m/s² after `time_s` [AH05 eq. 6.5]. Good for minutes: the
/// Schuler oscillation (84 min) bounds it later.
[[nodiscard]] constexpr double drift_of_accel_bias_m(double bias_mps2, double time_s) {
  return 0.5 * bias_mps2 * time_s * time_s;
}

/// δp = δω g t³/6 in m: a horizontal gyro's bias in rad/s tilts the platform, and gravity pulls [AH05 eq. 6.6]. Good
/// while the tilt δω t is small against 1 rad.
[[nodiscard]] constexpr double drift_of_gyro_bias_m(double bias_rps, double time_s, double gravity_mps2) {
  return bias_rps * gravity_mps2 * time_s * time_s * time_s / 6.0;
}

}  // namespace soak::nav
