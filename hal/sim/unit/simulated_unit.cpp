// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/unit/simulated_unit.h"

#include <fmt/format.h>

#include "base/random.h"
#include "hal/sim/unit/attitude.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;
using calib::Vector3;

SimulatedSensor draw_sensor(const CampaignConfig& config, std::uint64_t unit_seed, Sensor sensor) {
  const SensorMagnitudes& magnitudes = config.magnitudes(sensor);
  const std::size_t index = calib::index_of(sensor);
  SimulatedSensor drawn;
  base::Random bias_random(unit_seed, stream_of(Purpose::bias_curve, index));
  drawn.bias = ThermalCurve::draw(config.curve, magnitudes.bias, bias_random);
  if (!calib::is_gyro(sensor)) {
    base::Random scale_random(unit_seed, stream_of(Purpose::scale_curve, index));
    drawn.scale_ppm = ThermalCurve::draw(config.curve, magnitudes.scale_ppm, scale_random);
  }
  base::Random axes_random(unit_seed, stream_of(Purpose::axes, index));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double tilt = drawn_within(axes_random, magnitudes.misalignment_half_width_rad);
    if (axis != calib::axis_of(sensor)) drawn.misalignment[axis] = tilt;
    const double sign = drawn_sign(axes_random);
    drawn.g_sensitivity[axis] = sign * drawn_from(axes_random, magnitudes.g_sensitivity);
  }
  return drawn;
}

}  // namespace

std::string run_label(int run) { return run == kVerificationRun ? "V01" : fmt::format("R{:02}", run); }

std::uint64_t run_seed(const SimulatedUnit& unit, int run) {
  return base::hashed(unit.seed, stream_of(Purpose::run), static_cast<std::uint64_t>(run));
}

SimulatedUnit draw_unit(const CampaignConfig& config, int number) {
  SimulatedUnit unit;
  unit.serial = fmt::format("SIM-{:04}", number);
  unit.seed = base::hashed(config.seed, stream_of(Purpose::unit), static_cast<std::uint64_t>(number));
  for (const Sensor sensor : calib::kSensors) {
    unit.sensors[calib::index_of(sensor)] = draw_sensor(config, unit.seed, sensor);
  }
  return unit;
}

double power_on_offset(const CampaignConfig& config, const SimulatedUnit& unit, int run, Sensor sensor) {
  const std::uint64_t stream = stream_of(Purpose::power_on, calib::index_of(sensor));
  return config.magnitudes(sensor).power_on_sigma * base::hashed_gaussian(run_seed(unit, run), stream, 0);
}

SensorAtTemperature at_temperature(const SimulatedSensor& truth, double temp_c) {
  return {truth.bias.at(temp_c), 1.0 + 1e-6 * truth.scale_ppm.at(temp_c)};
}

double reading_of(const SimulatedSensor& truth, const SensorAtTemperature& state, Sensor sensor,
                  const Vector3& force_mps2, const Vector3& rate_rps) {
  const Vector3& input = calib::is_gyro(sensor) ? rate_rps : force_mps2;
  return state.scale * input[calib::axis_of(sensor)] + state.bias + dot(truth.misalignment, input) +
         dot(truth.g_sensitivity, force_mps2);
}

double ideal_reading(const SimulatedUnit& unit, Sensor sensor, double temp_c, const Vector3& force_mps2,
                     const Vector3& rate_rps) {
  const SimulatedSensor& truth = unit.sensors[calib::index_of(sensor)];
  return reading_of(truth, at_temperature(truth, temp_c), sensor, force_mps2, rate_rps);
}

}  // namespace soak::hal::sim
