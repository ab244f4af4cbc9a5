// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/lab_magnitudes.h"

#include <numbers>
#include <optional>

#include "base/units.h"

namespace soak::hal::sim {
namespace {

using calib::Vector3;
using settings::Limits;
using settings::Table;

constexpr Limits kLabTimeConstant_s = {0.5, 1e7};  // the physics advances in steps of 0.1 s
constexpr Limits kLabPositive = {1e-9, 1e6};
constexpr double kPerMinute = 1.0 / 60.0;
constexpr double kPerRootHour = 1.0 / 60.0;  // 1/√h in √Hz
constexpr double kPerHour = 1.0 / 3600.0;

PlantMagnitudes read_plant(const Table& root) {
  const Table table = root.section("lab_chamber", settings::kRequired);
  PlantMagnitudes plant;
  plant.room_c = table.number("room_c", kAnyTemperature_c);
  plant.heating_kps = kPerMinute * table.number("heating_kpmin", kLabPositive);
  plant.cooling_kps = kPerMinute * table.number("cooling_kpmin", kLabPositive);
  plant.load_to_air = table.number("load_to_air", {0.0, 100.0});
  plant.load_settling_time_s = table.number("load_settling_time_s", {10.0, 1e7});
  plant.leak_time_s = table.number("leak_time_s", {100.0, 1e7});
  plant.heater_lag_s = table.number("heater_lag_s", kLabTimeConstant_s);
  plant.refrigeration_lag_s = table.number("refrigeration_lag_s", kLabTimeConstant_s);
  plant.compressor_period_s = table.number("compressor_period_s", kLabTimeConstant_s);
  plant.compressor_depth = table.number("compressor_depth", {0.0, 1.0});
  return plant;
}

ControllerMagnitudes read_controller(const Table& root) {
  const Table table = root.section("lab_controller", settings::kRequired);
  ControllerMagnitudes controller;
  controller.gain_pk = 0.01 * table.number("gain_percent_per_k", kLabPositive);
  controller.integral_time_s = table.number("integral_time_s", kLabTimeConstant_s);
  controller.sensor_lag_s = table.number("sensor_lag_s", kLabTimeConstant_s);
  controller.sensor_noise_sigma_c = table.number("sensor_noise_sigma_c", kAnyMagnitude);
  controller.set_point_low_c = table.number("set_point_low_c", kAnyTemperature_c);
  controller.set_point_high_c = table.number("set_point_high_c", kAnyTemperature_c);
  controller.alarm_low_c = table.number("alarm_low_c", kAnyTemperature_c);
  controller.alarm_high_c = table.number("alarm_high_c", kAnyTemperature_c);
  controller.limit_high_c = table.number("limit_high_c", kAnyTemperature_c);
  if (controller.set_point_low_c >= controller.set_point_high_c) {
    table.refuse("set_point_high_c",
                 "'lab_controller.set_point_high_c' must be above 'lab_controller.set_point_low_c'");
  }
  return controller;
}

ElectronicsMagnitudes read_electronics(const Table& root) {
  const Table table = root.section("lab_unit", settings::kRequired);
  ElectronicsMagnitudes electronics;
  electronics.settling_time_s = read_range(table, "settling_time_s", kLabTimeConstant_s);
  electronics.load_coupling_time_s = table.number("load_coupling_time_s", kLabTimeConstant_s);
  electronics.self_heating_c = read_range(table, "self_heating_c", kAnyMagnitude);
  electronics.thermometer_noise_sigma_c = table.number("thermometer_noise_sigma_c", kAnyMagnitude);
  electronics.thermometer_lsb_c = table.number("thermometer_lsb_c", kLabPositive);
  electronics.boot_s = table.number("boot_s", {0.0, 100.0});
  electronics.wake_up_s = table.number("wake_up_s", {0.0, 100.0});
  return electronics;
}

OutputMagnitudes read_gyro(const Table& noise, const Table& unit) {
  OutputMagnitudes gyro;
  gyro.random_walk =
      base::kRadPerDeg * kPerRootHour * noise.number("gyro_angle_random_walk_deg_per_sqrt_h", kAnyMagnitude);
  gyro.bias_instability = base::kRadPerDeg * kPerHour * noise.number("gyro_bias_instability_deg_per_h", kAnyMagnitude);
  gyro.range = base::kRadPerDeg * unit.number("gyro_range_dps", kLabPositive);
  gyro.lsb = base::kRadPerDeg * unit.number("gyro_lsb_dps", kLabPositive);
  return gyro;
}

OutputMagnitudes read_accel(const Table& noise, const Table& unit) {
  OutputMagnitudes accel;
  accel.random_walk = kPerRootHour * noise.number("accel_velocity_random_walk_mps_per_sqrt_h", kAnyMagnitude);
  accel.bias_instability = noise.number("accel_bias_instability_mps2", kAnyMagnitude);
  accel.range = unit.number("accel_range_mps2", kLabPositive);
  accel.lsb = unit.number("accel_lsb_mps2", kLabPositive);
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

std::vector<Mounting> read_mountings(const Table& slots) {
  std::vector<Mounting> mountings;
  const auto texts = slots.texts("mountings", settings::kRequired);
  if (texts.empty() && slots.has("mountings")) slots.refuse("mountings", "'mountings' must be a list of texts");
  for (const std::string& text : texts) {
    const auto mounting = parse_mounting(text);
    if (!mounting) {
      slots.refuse(
          "mountings",
          "'" + text +
              "' in 'lab_slots.mountings' must name three fixture directions, right-handed, such as \"+Y-X+Z\"");
    }
    mountings.push_back(mounting.value_or(Mounting{}));
  }
  return mountings;
}

}  // namespace

LabMagnitudes read_lab_magnitudes(const Table& root) {
  const Table noise = root.section("lab_noise", settings::kRequired);
  const Table unit = root.section("lab_unit", settings::kRequired);
  LabMagnitudes lab;
  lab.plant = read_plant(root);
  lab.controller = read_controller(root);
  lab.electronics = read_electronics(root);
  lab.gyro = read_gyro(noise, unit);
  lab.accel = read_accel(noise, unit);
  lab.slow_correlation_times_s = read_some_numbers(noise, "correlation_times_s", kLabTimeConstant_s);
  const Table fixture = root.section("lab_fixture", settings::kRequired);
  lab.turn_s_per_rad = fixture.number("quarter_turn_s", {0.1, 1e4}) / (std::numbers::pi / 2.0);
  lab.mountings = read_mountings(root.section("lab_slots", settings::kRequired));
  return lab;
}

}  // namespace soak::hal::sim
