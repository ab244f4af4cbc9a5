// SPDX-License-Identifier: Apache-2.0
#include "calib/gravity.h"

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

}  // namespace

Gravity gravity_at(const Site& site) {
  if (site.gravity_mps2) return {*site.gravity_mps2, false};
  if (!site.latitude_deg) return {base::kStandardGravity_mps2, true};
  const double sin_latitude = std::sin(*site.latitude_deg * base::kRadPerDeg);
  const double s2 = sin_latitude * sin_latitude;
  const double at_ellipsoid =
      kEquatorialGravity_mps2 * (1.0 + kSomigliana * s2) / std::sqrt(1.0 - kEccentricitySquared * s2);
  const double h = site.height_m.value_or(0.0) / kSemiMajorAxis_m;
  return {at_ellipsoid * (1.0 - 2.0 * (1.0 + kFlattening + kGravityRatio - 2.0 * kFlattening * s2) * h + 3.0 * h * h),
          false};
}

double vertical_earth_rate_rps(double latitude_deg) {
  return base::kEarthRate_rps * std::sin(latitude_deg * base::kRadPerDeg);
}

}  // namespace soak::calib
