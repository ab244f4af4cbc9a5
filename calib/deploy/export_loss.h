// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// What an autopilot's cubic loses of one sensor's bias curve, evaluated in float32 as the autopilot does it, over a
/// fine even grid of the file's valid range. SI: rad/s, m/s².
struct CubicLoss {
  Sensor sensor = Sensor::gyro_x;
  double temp_min_c = 0.0;  ///< range that the file states for this sensor; beyond it the autopilot holds the end value
  double temp_max_c = 0.0;
  double reference_c = 0.0;     ///< temperature that the cubic is written about
  double rms = 0.0;             ///< difference cubic − curve
  double worst = 0.0;           ///< largest absolute difference
  double worst_temp_c = 0.0;    ///< where
  double ci95_at_worst = 0.0;   ///< half-width of the curve's own 95 % band there
  double beyond_ci95 = 0.0;     ///< share of the range, 0 to 1, in which the difference exceeds that band
  double steepest_per_c = 0.0;  ///< largest change of the correction per °C
  /// Least and greatest scale factor error where it was measured, in ppm: what the file cannot carry. Absent = unknown.
  std::optional<std::array<double, 2>> scale_ppm;
};

/// A parameter file for an autopilot.
struct AutopilotFile {
  std::string text;
  std::vector<CubicLoss> losses;   ///< in the order of sensors
  std::vector<std::string> notes;  ///< sentences: what the file does not do, what is left to the user
};

}  // namespace soak::calib
