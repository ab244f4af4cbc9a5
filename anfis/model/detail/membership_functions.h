// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>

#include "anfis/model/detail/elementary.h"
#include "anfis/model/membership.h"

// Membership functions through the logarithm of their degree: it never underflows, its derivatives stay finite where
// the degree does, and the product of degrees becomes a sum. `distance` is what a shape measures from its centre:
// ln t^2 for the bell, t^2 for Gaussians, with t = (u - centre) / width.
namespace soak::anfis::inference {

/// Keeps every power and product finite; no input of a real model comes near so many half ranges.
inline constexpr double kFarthest = 1e50;
/// Stands for ln 0 inside a triangle's or trapezoid's support, and for its distance outside: see log_degree().
inline constexpr double kNeverFires = -1e6;

SOAK_INLINE double bell_distance(double u, double width, double centre) {
  const double t = (u - centre) / width;
  return logarithm(t * t);
}

SOAK_INLINE double gaussian_distance(double u, double width, double centre) {
  const double t = (u - centre) / width;
  return t * t;
}

/// [AH05 eq. 5.6] 1 / (1 + (t^2)^b)
SOAK_INLINE double bell_degree(double distance, double slope) { return 1.0 / (1.0 + exponential(slope * distance)); }

/// [AH05 eq. 5.7] exp(-t^2 / 2)
SOAK_INLINE double gaussian_degree(double distance) { return exponential(-0.5 * distance); }

/// ln of the bell's degree: -ln(1 + z), z = (t^2)^b.
SOAK_INLINE double bell_log_degree(double distance, double slope) {
  const double power = slope * distance;
  return power > 0.0 ? -power - logarithm(1.0 + exponential(-power)) : -logarithm(1.0 + exponential(power));
}

/// d ln mu / d (width, slope, centre) of the bell. ln mu = -ln(1 + z), so d ln mu / d ln t = -2 b (1 - mu); where
/// 1 - mu is 0 (at the centre) all are 0.
SOAK_INLINE std::array<double, 3> bell_log_derivatives(double u, double distance, double degree, double width,
                                                       double slope, double centre) {
  const double rest = 1.0 - degree;
  const double offset = u - centre;
  const double safe_offset = offset == 0.0 ? 1.0 : offset;
  return {2.0 * slope * rest / width, -rest * distance, offset == 0.0 ? 0.0 : 2.0 * slope * rest / safe_offset};
}

/// d ln mu / d (width, centre) of the Gaussian.
SOAK_INLINE std::array<double, 2> gaussian_log_derivatives(double u, double distance, double width, double centre) {
  return {distance / width, (u - centre) / (width * width)};
}

/// mu of any shape at u; exactly 0 where a triangle or trapezoid does not fire.
[[nodiscard]] double degree_of(const Membership& membership, double u);

/// ln mu of any shape at u; see anfis::log_degree().
[[nodiscard]] double log_degree_of(const Membership& membership, double u);

/// d ln mu / d parameters of any shape at u; 0 where a triangle or trapezoid does not fire, the mean of both sides on
/// its kinks.
[[nodiscard]] std::array<double, 4> log_derivatives_of(const Membership& membership, double u);

}  // namespace soak::anfis::inference
