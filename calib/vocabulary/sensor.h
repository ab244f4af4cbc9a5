// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/units.h"

namespace soak::calib {

/// One of the six sensing axes of an inertial unit; the value is its index wherever six things are listed.
enum class Sensor : std::uint8_t { gyro_x, gyro_y, gyro_z, accel_x, accel_y, accel_z };

inline constexpr std::size_t kSensorCount = 6;

inline constexpr std::array<Sensor, kSensorCount> kSensors = {Sensor::gyro_x,  Sensor::gyro_y,  Sensor::gyro_z,
                                                              Sensor::accel_x, Sensor::accel_y, Sensor::accel_z};

inline constexpr std::array<std::string_view, kSensorCount> kSensorNames = {"gyro_x",  "gyro_y",  "gyro_z",
                                                                            "accel_x", "accel_y", "accel_z"};

constexpr std::size_t index_of(Sensor sensor) { return static_cast<std::size_t>(sensor); }

constexpr std::string_view name_of(Sensor sensor) { return kSensorNames[index_of(sensor)]; }

constexpr bool is_gyro(Sensor sensor) { return index_of(sensor) < 3; }

/// Body axis that the sensor measures along: 0, 1, 2 for x, y, z.
constexpr std::size_t axis_of(Sensor sensor) { return index_of(sensor) % 3; }

constexpr std::optional<Sensor> sensor_named(std::string_view name) {
  for (const Sensor sensor : kSensors) {
    if (name_of(sensor) == name) return sensor;
  }
  return std::nullopt;
}

/// Unit that results are printed in: deg/s for gyros (rad/s inside), m/s² for accelerometers.
constexpr std::string_view printed_unit(Sensor sensor) { return is_gyro(sensor) ? "deg/s" : "m/s2"; }

/// What an SI value is multiplied by to be printed in printed_unit().
constexpr double printed_per_si(Sensor sensor) { return is_gyro(sensor) ? base::kDegPerRad : 1.0; }

}  // namespace soak::calib
