// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace soak::hal::sim {

/// The laboratory's own time, counted in ticks of 2.5 ms: one internal sample of a unit.
using Tick = std::int64_t;

inline constexpr Tick kTicksPerSecond = 400;
/// Heat, controller and slow noise advance every 0.1 s.
inline constexpr Tick kTicksPerStep = 40;
inline constexpr double kStep_s = 0.1;

/// Tick that lies nothing or less than a tick after `duration_s`.
constexpr Tick ticks_of(double duration_s) {
  const double ticks = duration_s * static_cast<double>(kTicksPerSecond);
  const auto whole = static_cast<Tick>(ticks);
  return static_cast<double>(whole) < ticks ? whole + 1 : whole;
}

}  // namespace soak::hal::sim
