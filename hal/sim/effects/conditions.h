// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/vocabulary/position.h"

namespace soak::hal::sim {

/// Unix time at which every simulated laboratory begins: 2026-01-01 09:00:00.
inline constexpr double kFirstUtc_s = 1767258000.0;

/// What surrounds and drives a unit at one moment. Times only rise from one moment to the next; from one pass through
/// the chamber to the next they may stand still or jump ahead.
struct Conditions {
  double time_s = 0.0;            ///< device time since the laboratory began
  double utc_s = 0.0;             ///< Unix time
  double since_power_on_s = 0.0;  ///< 0 while the unit has no power
  bool powered = false;
  int run = 0;                 ///< ordinal of the power-on, from 0
  int mounting = 0;            ///< ordinal of the mounting on the fixture, from 0
  double thermometer_c = 0.0;  ///< the unit where its thermometer is, without noise
  double element_c = 0.0;      ///< the sensing elements
  double air_c = 0.0;          ///< of the chamber
  calib::Vector3 up{};         ///< unit vector in body axes
  double compressor = 0.0;     ///< 1 while it runs, else 0
  double supply_v = 0.0;
};

}  // namespace soak::hal::sim
