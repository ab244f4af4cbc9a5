// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/run.h"

namespace soak::calib {

/// Magnitude of gravity, whether it had to be assumed, and how well it is known.
struct Gravity {
  double mps2 = 0.0;
  bool assumed = false;  ///< neither given nor computable: the standard value 9.80665 stands in
  std::optional<double> standard_uncertainty_mps2 = std::nullopt;  ///< absent = nobody has stated it
  std::string basis = {};                                          ///< where the uncertainty comes from
};

/// The given value; else normal gravity on the WGS 84 ellipsoid (Somigliana) at the latitude with the second-order
/// free-air correction for height (0 where it is not given); else the standard value.
///
/// Standard uncertainty: of a given value it is not stated. Normal gravity differs from the real one by anomalies, of
/// 42 mGal root mean square over the Earth (variance 1795 mGal², Tscherning and Rapp 1974); 5e-4 m/s² is taken. An
/// unknown height adds ±1000 m, rectangular. The standard value stands for anything between equator and pole.
[[nodiscard]] Gravity gravity_at(const Site& site);

/// The site with the gravity of the register's reference, where the site itself gives none and the register does.
[[nodiscard]] Site with_reference_gravity(Site site, std::span<const ReferenceUse> references);

/// Component of the Earth's rotation along the local upward vertical, rad/s: Ω sin φ, north positive.
[[nodiscard]] double vertical_earth_rate_rps(double latitude_deg);

}  // namespace soak::calib
