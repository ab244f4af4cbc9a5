// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"
#include "calib/signal/allan/allan_fit.h"
#include "calib/signal/documents/signal_json.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// What a record must hold at rest without a gap for its random walk to mean anything: half an hour, which carries
/// averaging times of up to ten minutes.
inline constexpr double kKalibrLeastStill_s = 1800.0;
/// A swing of more is not the constant temperature that a random walk is to be taken at: the file says so.
inline constexpr double kKalibrMostSwing_k = 2.0;

/// Noise of one sensor at rest, from the Allan deviation's fit. SI: rad/s, m/s².
struct AxisNoise {
  Sensor sensor = Sensor::gyro_x;
  signal::AllanCoefficient density;      ///< N, white noise, in U/√Hz
  signal::AllanCoefficient random_walk;  ///< K, rate random walk, in U/√s = (U/s)/√Hz
  double rate_hz = 0.0;
  double longest_tau_s = 0.0;               ///< longest averaging time that the fit has seen
  double p_value = 1.0;                     ///< of the misfit (signal::AllanFit)
  std::optional<signal::LowPass> low_pass;  ///< of the unit: N is the density below its corner
};

/// Noise of a sensor from its record in printed units (deg/s, m/s²). Refuses a record whose longest averaging time is
/// below a third of kKalibrLeastStill_s, and what signal::fit_allan() refuses.
[[nodiscard]] base::Result<AxisNoise> axis_noise(Sensor sensor, const SignalRecord& record);

/// Where the noise comes from.
struct KalibrSource {
  std::string unit;  ///< serial number
  std::string unit_type;
  std::string run;  ///< label
  std::string content_sha256;
  std::string position;       ///< label; empty = not known
  double temp_c = 0.0;        ///< of the unit's own thermometer, mean
  double least_temp_c = 0.0;  ///< of its means over minutes
  double most_temp_c = 0.0;
  double recorded_utc_s = 0.0;
  double created_utc_s = 0.0;
  bool simulated = false;
};

/// One value of the file: the worst axis.
struct KalibrValue {
  std::string key;
  double value = 0.0;
  Sensor worst = Sensor::gyro_x;
  bool bound = false;  ///< the term was not found: the value is the upper end of its 95 % interval
};

/// A kalibr imu.yaml.
struct KalibrFile {
  std::string text;
  std::array<KalibrValue, 4> values;
};

/// The four noise values of kalibr, each that of the worst axis, under comments that state every axis with its
/// interval. A term that no curve shows is written as the upper end of its interval, because kalibr wants every value
/// above 0. Refuses noise without a gyro or without an accelerometer, and values that are not finite and above 0.
[[nodiscard]] base::Result<KalibrFile> export_kalibr(const KalibrSource& source, std::span<const AxisNoise> noise);

}  // namespace soak::calib
