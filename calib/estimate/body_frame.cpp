// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/body_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/units.h"
#include "calib/estimate/gravity.h"

namespace soak::calib {
namespace {

constexpr double kTie = 1e-9;  ///< two axes as near to the vertical as each other

/// a·x + b·y
Vector3 combined(double a, const Vector3& x, double b, const Vector3& y) {
  return {a * x[0] + b * y[0], a * x[1] + b * y[1], a * x[2] + b * y[2]};
}

Vector3 unit(const Vector3& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

/// The body axis that follows, cyclically, the one nearest the vertical, projected to the horizontal.
Vector3 reference_axis(const Vector3& up) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(up[i]) > std::abs(up[nearest]) + kTie) nearest = i;
  }
  const std::size_t next = (nearest + 1) % 3;
  Vector3 axis{};
  axis[next] = 1.0;
  return unit(combined(1.0, axis, -up[next], up));
}

}  // namespace

Frame frame_of(const Position& position, double site_azimuth_deg, const Tilt& tilt) {
  const double heading = (site_azimuth_deg + position.azimuth_deg.value_or(0.0)) * base::kRadPerDeg;
  const Vector3& up = position.up;
  const Vector3 forward = reference_axis(up);
  const Vector3 left = {up[1] * forward[2] - up[2] * forward[1], up[2] * forward[0] - up[0] * forward[2],
                        up[0] * forward[1] - up[1] * forward[0]};
  // forward = cos ψ · north + sin ψ · east, left = sin ψ · north − cos ψ · east
  const Vector3 north = combined(std::cos(heading), forward, std::sin(heading), left);
  const Vector3 east = combined(std::sin(heading), forward, -std::cos(heading), left);
  if (tilt.north_rad == 0.0 && tilt.east_rad == 0.0) return {up, north, east};
  Frame frame;
  frame.up = unit(combined(1.0, up, 1.0, combined(tilt.north_rad, north, tilt.east_rad, east)));
  const double lean = frame.up[0] * north[0] + frame.up[1] * north[1] + frame.up[2] * north[2];
  frame.north = unit(combined(1.0, north, -lean, frame.up));
  frame.east = {frame.north[1] * frame.up[2] - frame.north[2] * frame.up[1],
                frame.north[2] * frame.up[0] - frame.north[0] * frame.up[2],
                frame.north[0] * frame.up[1] - frame.north[1] * frame.up[0]};
  return frame;
}

bool turns(const Segment& segment) {
  return segment.position && segment.position->rate_dps && *segment.position->rate_dps != 0.0;
}

Headings headings_of(std::span<const Segment> segments, const Site& site) {
  Headings headings;
  const Position* without = nullptr;
  bool any_position = false;
  for (const Segment& segment : segments) {
    if (!segment.position || turns(segment)) continue;
    any_position = true;
    headings.begun = headings.begun || segment.position->azimuth_deg.has_value();
    if (without == nullptr && !segment.position->azimuth_deg) without = &*segment.position;
  }
  if (!any_position) {
    headings.missing = "no position in which the unit rested is known";
  } else if (!headings.begun) {
    headings.missing = "the positions have no azimuth";
  } else if (without != nullptr) {
    headings.missing = fmt::format("position '{}' has no azimuth, others have one", without->label);
  } else if (!site.azimuth_deg) {
    headings.missing =
        "the heading of the fixture is not known (--azimuth-deg at import, azimuth_deg in the station's [site])";
  }
  headings.complete = headings.missing.empty();
  return headings;
}

EarthRate known_earth_rate(std::span<const Segment> segments, const Site& site) {
  if (!site.latitude_deg) return {};
  EarthRate rate;
  rate.vertical_rps = vertical_earth_rate_rps(*site.latitude_deg);
  if (headings_of(segments, site).complete) {
    rate.horizontal_rps = base::kEarthRate_rps * std::cos(*site.latitude_deg * base::kRadPerDeg);
  }
  return rate;
}

}  // namespace soak::calib
