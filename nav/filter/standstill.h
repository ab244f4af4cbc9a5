// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "nav/drive/drive.h"

namespace soak::nav {

/// The vehicle stands where over the last `window_s` the readings scatter less than this.
struct Standstill {
  double window_s = 1.0;
  double rate_sigma_rps = 0.0;       ///< largest standard deviation of any gyro
  double force_sigma_mps2 = 0.0;     ///< largest standard deviation of any accelerometer
  double velocity_sigma_mps = 0.02;  ///< of the velocity 0 that is then taken for measured
};

/// Whether the vehicle stands by the readings of such a window.
[[nodiscard]] bool stands(std::span<const ImuSample> window, const Standstill& limits);

/// Limits from the rest at the beginning of a drive: the scatter of the second of it in which the readings scatter
/// most. Nothing where the rest is shorter than 20 s.
[[nodiscard]] std::optional<Standstill> standstill_at_rest(const Drive& drive);

}  // namespace soak::nav
