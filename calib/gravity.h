// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/run.h"

namespace soak::calib {

/// Magnitude of gravity and whether it had to be assumed.
struct Gravity {
  double mps2 = 0.0;
  bool assumed = false;  ///< neither given nor computable: the standard value 9.80665 stands in
};

/// The given value; else normal gravity on the WGS 84 ellipsoid (Somigliana) at the latitude with the second-order
/// free-air correction for height (0 where it is not given); else the standard value.
[[nodiscard]] Gravity gravity_at(const Site& site);

/// Component of the Earth's rotation along the local upward vertical, rad/s: Ω sin φ, north positive.
[[nodiscard]] double vertical_earth_rate_rps(double latitude_deg);

}  // namespace soak::calib
