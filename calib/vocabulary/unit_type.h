// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// `one` for the whole unit, or one beside each sensor.
enum class Thermometers : std::uint8_t { one, per_sensor };

/// Largest absolute errors that a calibration may have against the unit as it is; absent = no limit.
struct Limits {
  std::array<std::optional<double>, kSensorCount> bias;  ///< SI
  std::array<std::optional<double>, kSensorCount> scale_ppm;

  /// Of the bias.
  std::optional<double>& operator[](std::size_t sensor) { return bias[sensor]; }
  std::optional<double> operator[](std::size_t sensor) const { return bias[sensor]; }

  bool operator==(const Limits&) const = default;
};

/// What all units of one make have in common. Values that are not known are absent, never guessed.
struct UnitType {
  std::string name = "generic";
  std::string description;
  std::optional<double> temp_min_c;  ///< operating temperature rating
  std::optional<double> temp_max_c;
  std::optional<double> gyro_range_dps;
  std::optional<double> accel_range_mps2;
  std::optional<double> gyro_lsb_dps;  ///< output step
  std::optional<double> accel_lsb_mps2;
  std::optional<Thermometers> thermometers;
  std::optional<double> temp_lsb_c;  ///< output step of the thermometers
  /// Standard uncertainty with which the same reading means the same temperature of the sensors, in the chamber and in
  /// use.
  std::optional<double> temp_repeatability_c;
  /// +1 where the accelerometer of the axis that points up reads +g at rest (specific force), −1 where it reads −g.
  int sign_at_rest = +1;
  /// Body directions ("+X" ... "-Z") of the axes x, y, z that the device sends, right-handed; absent = the body's own.
  std::optional<std::array<std::string, 3>> axes;
  std::optional<double> warm_up_s;  ///< after power-on until the maker's figures hold

  /// Limits of the pre-flight check, of every axis; absent = the figure is reported and not judged. Noise is the
  /// density of the white part (square root of the one-sided spectrum): samples of standard deviation s at R per second
  /// that are white have s·√(2/R).
  std::optional<double> gyro_noise_max_dps_rthz;
  std::optional<double> accel_noise_max_mps2_rthz;
  std::optional<double> gyro_bias_max_dps;  ///< at the temperature of the room
  std::optional<double> accel_bias_max_mps2;

  /// How far, in K, constants that were measured at one temperature hold beyond it, and how much they change per kelvin
  /// there at most.
  double constants_within_c = 0.0;
  std::optional<double> gyro_bias_per_k_dps;
  std::optional<double> accel_bias_per_k_mps2;
  std::optional<double> gyro_scale_per_k_ppm;
  std::optional<double> accel_scale_per_k_ppm;

  /// Thermal hysteresis: difference of the bias between heating and cooling at the same temperature, at its largest.
  std::optional<double> gyro_hysteresis_dps;
  std::optional<double> accel_hysteresis_mps2;

  Limits limits;  ///< of `soak verify`
};

}  // namespace soak::calib
