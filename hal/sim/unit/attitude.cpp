// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/unit/attitude.h"

#include <cmath>

namespace soak::hal::sim {
namespace {

using calib::Vector3;

/// a·x + b·y
Vector3 combined(double a, const Vector3& x, double b, const Vector3& y) {
  return {a * x[0] + b * y[0], a * x[1] + b * y[1], a * x[2] + b * y[2]};
}

/// The body axis that follows, cyclically, the one along `up`.
Vector3 reference_axis(const Vector3& up) { return {std::abs(up[2]), std::abs(up[0]), std::abs(up[1])}; }

}  // namespace

Attitude resting(const calib::Position& position, const std::optional<EarthFrame>& earth) {
  Attitude attitude{position.up, {}};
  if (!earth) return attitude;
  const double latitude = earth->latitude_deg * base::kRadPerDeg;
  const double azimuth = earth->azimuth_deg * base::kRadPerDeg;
  const Vector3 forward = reference_axis(position.up);
  const Vector3 north = combined(std::cos(azimuth), forward, std::sin(azimuth), cross(position.up, forward));
  // Ω (sin φ · up + cos φ · north)
  attitude.rate_rps = combined(base::kEarthRate_rps * std::sin(latitude), position.up,
                               base::kEarthRate_rps * std::cos(latitude), north);
  return attitude;
}

Attitude turning(const calib::Position& from, const calib::Position& to, double fraction, double duration_s) {
  const double cosine = dot(from.up, to.up);
  const double angle = std::acos(cosine);
  const bool opposite = cosine < -0.5;
  // Up is fixed in space: in body axes it moves with d(up)/dt = up × rate, towards `sideways`.
  const Vector3 axis = opposite ? reference_axis(from.up) : cross(to.up, from.up);
  const Vector3 sideways = cross(from.up, axis);
  const double turned = fraction * angle;
  const double rate = angle / duration_s;
  return {combined(std::cos(turned), from.up, std::sin(turned), sideways), combined(rate, axis, 0.0, axis)};
}

}  // namespace soak::hal::sim
