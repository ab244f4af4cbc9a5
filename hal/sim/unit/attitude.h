// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "base/units.h"
#include "calib/vocabulary/position.h"
#include "hal/sim/config/campaign_config.h"

namespace soak::hal::sim {

[[nodiscard]] inline double dot(const calib::Vector3& a, const calib::Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

[[nodiscard]] inline calib::Vector3 cross(const calib::Vector3& a, const calib::Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Specific force in m/s² of a body at rest, whose axes see `up`.
[[nodiscard]] inline calib::Vector3 force_at_rest_mps2(const calib::Vector3& up) {
  constexpr double g = base::kStandardGravity_mps2;
  return {g * up[0], g * up[1], g * up[2]};
}

/// How the fixture holds or turns a unit at one moment, in the unit's body axes.
struct Attitude {
  calib::Vector3 up{};        ///< unit vector
  calib::Vector3 rate_rps{};  ///< rotation of the body against inertial space
};

/// At rest in one of the six positions. With `earth`, the body axis after the vertical one (x → y → z → x) points at
/// `earth->azimuth_deg` and the rotation of the Earth is the rate.
[[nodiscard]] Attitude resting(const calib::Position& position, const std::optional<EarthFrame>& earth);

/// `fraction` (0 ... 1) of the way from one position to another, on a great circle at constant rate for `duration_s`.
/// Opposite positions turn about the body axis after the vertical one. The rate is that of the fixture alone: the
/// Earth's is four orders below it.
[[nodiscard]] Attitude turning(const calib::Position& from, const calib::Position& to, double fraction,
                               double duration_s);

}  // namespace soak::hal::sim
