// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/lab_magnitudes.h"

#include <numbers>
#include <optional>

#include "base/units.h"
#include "hal/sim/config/config_reader.h"

namespace soak::hal::sim {
namespace {

using calib::Vector3;
using Limits = ConfigReader::Limits;

constexpr Limits kTemperature_c = {-200.0, 300.0};
constexpr Limits kTimeConstant_s = {0.5, 1e7};  // the physics advances in steps of 0.1 s
constexpr Limits kPositive = {1e-9, 1e6};
constexpr Limits kMagnitude = {0.0, 1e6};
constexpr double kPerMinute = 1.0 / 60.0;
constexpr double kPerRootHour = 1.0 / 60.0;  // 1/√h in √Hz
constexpr double kPerHour = 1.0 / 3600.0;

PlantMagnitudes read_plant(ConfigReader& reader) {
  PlantMagnitudes plant;
  plant.room_c = reader.number("lab_chamber.room_c", kTemperature_c);
  plant.heating_kps = kPerMinute * reader.number("lab_chamber.heating_kpmin", kPositive);
  plant.cooling_kps = kPerMinute * reader.number("lab_chamber.cooling_kpmin", kPositive);
  plant.load_to_air = reader.number("lab_chamber.load_to_air", {0.0, 100.0});
  plant.load_settling_time_s = reader.number("lab_chamber.load_settling_time_s", {10.0, 1e7});
  plant.leak_time_s = reader.number("lab_chamber.leak_time_s", {100.0, 1e7});
  plant.heater_lag_s = reader.number("lab_chamber.heater_lag_s", kTimeConstant_s);
  plant.refrigeration_lag_s = reader.number("lab_chamber.refrigeration_lag_s", kTimeConstant_s);
  plant.compressor_period_s = reader.number("lab_chamber.compressor_period_s", kTimeConstant_s);
  plant.compressor_depth = reader.number("lab_chamber.compressor_depth", {0.0, 1.0});
  return plant;
}

ControllerMagnitudes read_controller(ConfigReader& reader) {
  ControllerMagnitudes controller;
  controller.gain_pk = 0.01 * reader.number("lab_controller.gain_percent_per_k", kPositive);
  controller.integral_time_s = reader.number("lab_controller.integral_time_s", kTimeConstant_s);
  controller.sensor_lag_s = reader.number("lab_controller.sensor_lag_s", kTimeConstant_s);
  controller.sensor_noise_sigma_c = reader.number("lab_controller.sensor_noise_sigma_c", kMagnitude);
  controller.set_point_low_c = reader.number("lab_controller.set_point_low_c", kTemperature_c);
  controller.set_point_high_c = reader.number("lab_controller.set_point_high_c", kTemperature_c);
  controller.alarm_low_c = reader.number("lab_controller.alarm_low_c", kTemperature_c);
  controller.alarm_high_c = reader.number("lab_controller.alarm_high_c", kTemperature_c);
  controller.limit_high_c = reader.number("lab_controller.limit_high_c", kTemperature_c);
  if (controller.set_point_low_c >= controller.set_point_high_c) {
    reader.refuse("lab_controller.set_point_high_c",
                  "'lab_controller.set_point_high_c' must be above 'lab_controller.set_point_low_c'");
  }
  return controller;
}

ElectronicsMagnitudes read_electronics(ConfigReader& reader) {
  ElectronicsMagnitudes electronics;
  electronics.settling_time_s = reader.range("lab_unit.settling_time_s", kTimeConstant_s);
  electronics.load_coupling_time_s = reader.number("lab_unit.load_coupling_time_s", kTimeConstant_s);
  electronics.self_heating_c = reader.range("lab_unit.self_heating_c", kMagnitude);
  electronics.thermometer_noise_sigma_c = reader.number("lab_unit.thermometer_noise_sigma_c", kMagnitude);
  electronics.thermometer_lsb_c = reader.number("lab_unit.thermometer_lsb_c", kPositive);
  electronics.boot_s = reader.number("lab_unit.boot_s", {0.0, 100.0});
  electronics.wake_up_s = reader.number("lab_unit.wake_up_s", {0.0, 100.0});
  return electronics;
}

OutputMagnitudes read_gyro(ConfigReader& reader) {
  OutputMagnitudes gyro;
  gyro.random_walk =
      base::kRadPerDeg * kPerRootHour * reader.number("lab_noise.gyro_angle_random_walk_deg_per_sqrt_h", kMagnitude);
  gyro.bias_instability =
      base::kRadPerDeg * kPerHour * reader.number("lab_noise.gyro_bias_instability_deg_per_h", kMagnitude);
  gyro.range = base::kRadPerDeg * reader.number("lab_unit.gyro_range_dps", kPositive);
  gyro.lsb = base::kRadPerDeg * reader.number("lab_unit.gyro_lsb_dps", kPositive);
  return gyro;
}

OutputMagnitudes read_accel(ConfigReader& reader) {
  OutputMagnitudes accel;
  accel.random_walk = kPerRootHour * reader.number("lab_noise.accel_velocity_random_walk_mps_per_sqrt_h", kMagnitude);
  accel.bias_instability = reader.number("lab_noise.accel_bias_instability_mps2", kMagnitude);
  accel.range = reader.number("lab_unit.accel_range_mps2", kPositive);
  accel.lsb = reader.number("lab_unit.accel_lsb_mps2", kPositive);
  return accel;
}

double triple_product(const std::array<Vector3, 3>& axes) {
  const auto& [x, y, z] = axes;
  return (x[1] * y[2] - x[2] * y[1]) * z[0] + (x[2] * y[0] - x[0] * y[2]) * z[1] + (x[0] * y[1] - x[1] * y[0]) * z[2];
}

/// The mounting that a text such as "+Y-X+Z" names; nothing unless it is right-handed.
std::optional<Mounting> parse_mounting(const std::string& text) {
  if (text.size() != 6) return std::nullopt;
  Mounting mounting;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto direction = calib::position_named(std::string_view(text).substr(2 * axis, 2));
    if (!direction) return std::nullopt;
    mounting.labels[axis] = direction->label;
    mounting.axes[axis] = direction->up;
  }
  if (triple_product(mounting.axes) < 0.5) return std::nullopt;
  return mounting;
}

std::vector<Mounting> read_mountings(ConfigReader& reader) {
  std::vector<Mounting> mountings;
  for (const std::string& text : reader.texts("lab_slots.mountings")) {
    const auto mounting = parse_mounting(text);
    if (!mounting) {
      reader.refuse("lab_slots.mountings", "'" + text +
                                               "' in 'lab_slots.mountings' must name three fixture directions, "
                                               "right-handed, such as \"+Y-X+Z\"");
    }
    mountings.push_back(mounting.value_or(Mounting{}));
  }
  return mountings;
}

}  // namespace

LabMagnitudes read_lab_magnitudes(ConfigReader& reader) {
  LabMagnitudes lab;
  lab.plant = read_plant(reader);
  lab.controller = read_controller(reader);
  lab.electronics = read_electronics(reader);
  lab.gyro = read_gyro(reader);
  lab.accel = read_accel(reader);
  lab.slow_correlation_times_s = reader.numbers("lab_noise.correlation_times_s", kTimeConstant_s);
  lab.turn_s_per_rad = reader.number("lab_fixture.quarter_turn_s", {0.1, 1e4}) / (std::numbers::pi / 2.0);
  lab.mountings = read_mountings(reader);
  return lab;
}

}  // namespace soak::hal::sim
