// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "calib/vocabulary/position.h"
#include "hal/sim/config/range.h"

namespace soak::hal::sim {

/// Heat flows of the chamber. Powers are stated as the rate at which they warm or cool air and load together.
struct PlantMagnitudes {
  double room_c = 0.0;
  double heating_kps = 0.0;
  double cooling_kps = 0.0;
  double load_to_air = 0.0;           ///< heat capacity of the load over that of the air
  double load_settling_time_s = 0.0;  ///< of the load towards the air
  double leak_time_s = 0.0;           ///< of air and load together towards the room
  double heater_lag_s = 0.0;
  double refrigeration_lag_s = 0.0;
  double compressor_period_s = 0.0;
  double compressor_depth = 0.0;  ///< share by which the cooling swings about its mean
};

/// The temperature controller of the chamber.
struct ControllerMagnitudes {
  double gain_pk = 0.0;  ///< share of full output per kelvin of error
  double integral_time_s = 0.0;
  double sensor_lag_s = 0.0;
  double sensor_noise_sigma_c = 0.0;
  double set_point_low_c = 0.0;
  double set_point_high_c = 0.0;
  double alarm_low_c = 0.0;
  double alarm_high_c = 0.0;
  double limit_high_c = 0.0;  ///< of the independent protector
};

/// Temperature and electronics of the units.
struct ElectronicsMagnitudes {
  Range settling_time_s;            ///< of the unit towards the air
  double load_coupling_time_s = 0;  ///< of the unit towards the load, were there no air
  Range self_heating_c;             ///< above the air, in a powered unit
  double thermometer_noise_sigma_c = 0.0;
  double thermometer_lsb_c = 0.0;
  double boot_s = 0.0;
  double wake_up_s = 0.0;  ///< how long a started unit waits for an answer to WakeUp
};

/// Noise and range of one kind of sensor: rad/s for gyros, m/s² for accelerometers.
struct OutputMagnitudes {
  double random_walk = 0.0;       ///< angle or velocity random walk: white noise, SI unit per √Hz
  double bias_instability = 0.0;  ///< B: the Allan deviation of the slow noise has its floor at 0.664 B
  double range = 0.0;             ///< output is clipped at minus and plus this
  double lsb = 0.0;
};

/// How a unit is mounted: the fixture directions of its own axes.
struct Mounting {
  std::array<std::string, 3> labels;  ///< of the unit's x, y, z axes, such as "+Y"
  std::array<calib::Vector3, 3> axes{};
};

/// Magnitudes that the simulated laboratory has and the simulated campaign has not. SI and °C.
struct LabMagnitudes {
  PlantMagnitudes plant;
  ControllerMagnitudes controller;
  ElectronicsMagnitudes electronics;
  OutputMagnitudes gyro;
  OutputMagnitudes accel;
  std::vector<double> slow_correlation_times_s;
  double turn_s_per_rad = 0.0;      ///< of the fixture
  std::vector<Mounting> mountings;  ///< that slots take in turn

  /// Mounting of slot `number`, from 1.
  [[nodiscard]] const Mounting& mounting(int number) const {
    return mountings[static_cast<std::size_t>(number - 1) % mountings.size()];
  }
};

/// Reads the sections lab_* of lab.toml; mistakes are recorded in it.
[[nodiscard]] LabMagnitudes read_lab_magnitudes(const settings::Table& root);

}  // namespace soak::hal::sim
