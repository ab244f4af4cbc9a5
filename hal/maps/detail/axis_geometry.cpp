// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/axis_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/units.h"

namespace soak::hal {
namespace {

using calib::Vector3;

constexpr double kCosineOfOneDegree = 0.99984770;

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Rodrigues: v cos t + (k x v) sin t + k (k . v)(1 - cos t)
Vector3 turned(const Vector3& v, const Vector3& k, double angle_deg) {
  const double cosine = std::cos(angle_deg * base::kRadPerDeg);
  const double sine = std::sin(angle_deg * base::kRadPerDeg);
  const Vector3 sideways = cross(k, v);
  const double along = dot(k, v) * (1.0 - cosine);
  Vector3 result{};
  for (std::size_t i = 0; i < 3; ++i) result[i] = v[i] * cosine + sideways[i] * sine + k[i] * along;
  return result;
}

/// The axis that follows, cyclically, the one nearest to `up`.
Vector3 axis_after(const Vector3& up) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(up[i]) > std::abs(up[nearest])) nearest = i;
  }
  Vector3 axis{};
  axis[(nearest + 1) % 3] = 1.0;
  return axis;
}

}  // namespace

double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector3 up_at(const AxisDirections& axes, const AxisAngles& angles) {
  return turned(turned(axes.up, axes.outer, -angles.outer_deg), axes.inner, -angles.inner_deg);
}

double heading_deg(const AxisDirections& axes, const AxisAngles& angles) {
  const Vector3 own = axis_after(up_at(axes, angles));
  const Vector3 in_room = turned(turned(own, axes.inner, angles.inner_deg), axes.outer, angles.outer_deg);
  const Vector3 forward = axis_after(axes.up);
  const Vector3 left = cross(axes.up, forward);
  return -std::atan2(dot(in_room, left), dot(in_room, forward)) * base::kDegPerRad;
}

int sense_about_up(const AxisDirections& axes, FixtureAxis axis, const AxisAngles& angles) {
  // The outer axis stands still in the room, the inner one in the fixture.
  const double cosine = axis == FixtureAxis::outer ? dot(axes.outer, axes.up) : dot(axes.inner, up_at(axes, angles));
  if (std::abs(cosine) < kCosineOfOneDegree) return 0;
  return cosine > 0.0 ? 1 : -1;
}

}  // namespace soak::hal
