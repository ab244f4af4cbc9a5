// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/site.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/units.h"

namespace soak::calib {
namespace {

// WGS 84 (NIMA TR8350.2, tables 3.1, 3.4, 4.1).
constexpr double kEquatorialGravity_mps2 = 9.7803253359;
constexpr double kSomigliana = 0.00193185265241;
constexpr double kEccentricitySquared = 0.00669437999014;
constexpr double kSemiMajorAxis_m = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kGravityRatio = 0.00344978650684;  // m = ω²a²b/GM

constexpr double kPole_mps2 = 9.8321849379;
constexpr double kAnomaly_mps2 = 5e-4;
constexpr double kFreeAir_per_s2 = 3.086e-6;  ///< fall of gravity per metre of height
constexpr double kUnknownHeight_m = 1000.0;   ///< half-width

/// Standard deviation of a rectangular distribution of given half-width.
double rectangular(double half_width) { return half_width / std::sqrt(3.0); }

Gravity normal_gravity(double latitude_deg, const std::optional<double>& height_m) {
  const double mps2 = normal_gravity_mps2(std::sin(latitude_deg * base::kRadPerDeg), height_m.value_or(0.0));
  if (height_m) return {mps2, false, kAnomaly_mps2, "latitude and height; anomalies of gravity of 50 mGal (1 sigma)"};
  return {mps2, false, std::hypot(kAnomaly_mps2, rectangular(kFreeAir_per_s2 * kUnknownHeight_m)),
          "latitude; height unknown to ±1000 m"};
}

constexpr double kTie = 1e-9;  ///< two axes as near to the vertical as each other

/// a·x + b·y
Vector3 combined(double a, const Vector3& x, double b, const Vector3& y) {
  return {a * x[0] + b * y[0], a * x[1] + b * y[1], a * x[2] + b * y[2]};
}

Vector3 normalised(const Vector3& v) {
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
  return normalised(combined(1.0, axis, -up[next], up));
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

}  // namespace

double normal_gravity_mps2(double sin_latitude, double height_m) {
  const double s2 = sin_latitude * sin_latitude;
  const double at_ellipsoid =
      kEquatorialGravity_mps2 * (1.0 + kSomigliana * s2) / std::sqrt(1.0 - kEccentricitySquared * s2);
  const double h = height_m / kSemiMajorAxis_m;
  return at_ellipsoid * (1.0 - 2.0 * (1.0 + kFlattening + kGravityRatio - 2.0 * kFlattening * s2) * h + 3.0 * h * h);
}

Gravity gravity_at(const Site& site) {
  if (site.gravity_mps2) {
    return {*site.gravity_mps2, false, std::nullopt,
            "not stated: gravity was given without an uncertainty ('soak reference add --kind gravity')"};
  }
  if (site.latitude_deg) return normal_gravity(*site.latitude_deg, site.height_m);
  const double farthest =
      std::max(base::kStandardGravity_mps2 - kEquatorialGravity_mps2, kPole_mps2 - base::kStandardGravity_mps2);
  return {base::kStandardGravity_mps2, true, rectangular(farthest), "assumed: anything between equator and pole"};
}

Site with_reference_gravity(Site site, std::span<const ReferenceUse> references) {
  for (const ReferenceUse& use : references) {
    if (site.gravity_mps2 || use.reference.kind != ReferenceKind::gravity) continue;
    site.gravity_mps2 = use.reference.correction;
  }
  return site;
}

double vertical_earth_rate_rps(double latitude_deg) {
  return base::kEarthRate_rps * std::sin(latitude_deg * base::kRadPerDeg);
}

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
  frame.up = normalised(combined(1.0, up, 1.0, combined(tilt.north_rad, north, tilt.east_rad, east)));
  const double lean = frame.up[0] * north[0] + frame.up[1] * north[1] + frame.up[2] * north[2];
  frame.north = normalised(combined(1.0, north, -lean, frame.up));
  frame.east = {frame.north[1] * frame.up[2] - frame.north[2] * frame.up[1],
                frame.north[2] * frame.up[0] - frame.north[0] * frame.up[2],
                frame.north[0] * frame.up[1] - frame.north[1] * frame.up[0]};
  return frame;
}

Place place_of(std::span<const Segment> segments, const Site& site) {
  Place place{gravity_at(site), headings_of(segments, site), {}, site.latitude_deg, std::nullopt};
  if (place.headings.complete) place.azimuth_deg = site.azimuth_deg;
  if (!site.latitude_deg) return place;
  place.earth.vertical_rps = vertical_earth_rate_rps(*site.latitude_deg);
  if (place.headings.complete) {
    place.earth.horizontal_rps = base::kEarthRate_rps * std::cos(*site.latitude_deg * base::kRadPerDeg);
  }
  return place;
}

}  // namespace soak::calib
