// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/gravity.h"

#include <algorithm>
#include <cmath>

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
  const double sin_latitude = std::sin(latitude_deg * base::kRadPerDeg);
  const double s2 = sin_latitude * sin_latitude;
  const double at_ellipsoid =
      kEquatorialGravity_mps2 * (1.0 + kSomigliana * s2) / std::sqrt(1.0 - kEccentricitySquared * s2);
  const double h = height_m.value_or(0.0) / kSemiMajorAxis_m;
  const double mps2 =
      at_ellipsoid * (1.0 - 2.0 * (1.0 + kFlattening + kGravityRatio - 2.0 * kFlattening * s2) * h + 3.0 * h * h);
  if (height_m) return {mps2, false, kAnomaly_mps2, "latitude and height; anomalies of gravity of 50 mGal (1 sigma)"};
  return {mps2, false, std::hypot(kAnomaly_mps2, rectangular(kFreeAir_per_s2 * kUnknownHeight_m)),
          "latitude; height unknown to ±1000 m"};
}

}  // namespace

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

}  // namespace soak::calib
