// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"

/// A calibration in the forms that others read: text that the caller writes into a file.
namespace soak::calib {

/// The calibration file as a C99 header: the bytes as a constant array for soak_runtime.h, under a comment that says
/// where they come from, what they were measured with (references, waivers) and how to use them. A header made from
/// simulated data compiles only where SOAK_ACCEPT_SIMULATED is defined, one of a model that is not released only where
/// SOAK_ACCEPT_UNRELEASED is. Fails as encode() does.
[[nodiscard]] base::Result<std::string> export_c(const Calibration& calibration);

/// The whole calibration as one JSON document for people and scripts (docs/schema/calibration.schema.json), ending in a
/// line feed: provenance, and for each sensor its parameters and its curve at temp_min_c, every 1 °C, and temp_max_c.
/// Biases are in printed units (deg/s, m/s²), parameters too; scale factor errors in ppm. Refuses numbers that are not
/// finite, which JSON cannot carry, and models that anfis::validate_curve() refuses, which the document has no members
/// for.
[[nodiscard]] base::Result<std::string> export_json(const Calibration& calibration);

// ---- parameters of autopilots: one cubic for each sensor ----

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

inline constexpr int kPx4Instances = 4;

/// Where in PX4 the parameters go.
struct Px4Options {
  int instance = 0;  ///< 0 to 3: the n of TC_An_*, TC_Gn_*
  /// Device ids that PX4 binds the parameters to (CAL_ACCn_ID, CAL_GYROn_ID on the vehicle); absent: left out, and PX4
  /// applies nothing until the user has set them.
  std::optional<std::int32_t> accel_id;
  std::optional<std::int32_t> gyro_id;
  bool relative_accel = false;  ///< the accelerometers' bias has no level of its own (SensorFit::relative)
};

/// A PX4 parameter file (tab-separated "1 1 NAME VALUE TYPE", type 6 int32, 9 float32) with TC_A_ENABLE, TC_G_ENABLE
/// and TC_An_*, TC_Gn_*: per axis offset = X0 + X1 d + X2 d² + X3 d³ with d = T − TREF, T held at [TMIN, TMAX], which
/// PX4 subtracts from the raw value in rad/s, m/s². Each cubic is the least squares fit to the bias curve over the
/// range in which the three axes are valid, weighted by 1/ci95²; TREF is the middle of that range. A kind without
/// sensors is left out. Refuses an instance out of range, a kind with one or two axes, and axes without a common range.
[[nodiscard]] base::Result<AutopilotFile> export_px4(const Calibration& calibration, const Px4Options& options);

inline constexpr int kArduPilotInstances = 3;
inline constexpr double kArduPilotReference_c = 35.0;

/// Where in ArduPilot the parameters go.
struct ArduPilotOptions {
  int instance = 0;             ///< 0 to 2: IMU 1 to 3
  bool relative_accel = false;  ///< the accelerometers' bias has no level of its own (SensorFit::relative)
};

/// An ArduPilot parameter file ("NAME VALUE") with INS_TCALn_*. The correction is −p(T) + p(CALTEMP) − OFFS with
/// p(T) = 1e-6 (C1 d + C2 d² + C3 d³), d = T − 35 °C, both temperatures held at [TMIN, TMAX], one range for all six
/// sensors; rad/s, m/s². The cubic is the least squares fit with a free constant to the bias curve, weighted by
/// 1/ci95². Its constant part is written as INS_GYRnOFFS, INS_ACCnOFFS together with the temperature that they hold for
/// (INS_*_CALTEMP: 35 °C, or the end of the range nearest to it): one without the other would move every correction.
/// For accelerometers without a level of their own both are left out. A kind without sensors gets zero coefficients.
/// Refuses an instance out of range, a kind with one or two axes, and sensors without a common range.
[[nodiscard]] base::Result<AutopilotFile> export_ardupilot(const Calibration& calibration,
                                                           const ArduPilotOptions& options);

}  // namespace soak::calib
