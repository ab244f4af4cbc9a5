// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "calib/vocabulary/position.h"
#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/unit/thermal_curve.h"

namespace soak::hal::sim {

/// Number of the verification run among the runs of a unit; those of the campaign count from 1.
inline constexpr int kVerificationRun = 0;

/// Label of a run in the `run` column: "V01" for the verification run, else "R01", "R02"...
[[nodiscard]] std::string run_label(int run);

/// What is true of one sensor, without noise. For input u (specific force or rotation rate) along the sensor's axis:
///
///   raw = (1 + scale_ppm(T)·1e-6)·u + bias(T) + misalignment·u⃗ + g_sensitivity·f⃗ + power-on offset
struct SimulatedSensor {
  ThermalCurve bias;               ///< mean over power-ons, rad/s or m/s²
  ThermalCurve scale_ppm;          ///< zero for gyros
  calib::Vector3 misalignment{};   ///< rad; zero on the sensor's own axis
  calib::Vector3 g_sensitivity{};  ///< rad/s per m/s²; zero for accelerometers
};

/// A made-up inertial unit: all that a perfect calibration could find out about it.
struct SimulatedUnit {
  std::string serial;      ///< SIM-0001, ...
  std::uint64_t seed = 0;  ///< of all random numbers that belong to this unit
  std::array<SimulatedSensor, calib::kSensorCount> sensors;
};

/// Seed of the random numbers that belong to one run of a unit.
[[nodiscard]] std::uint64_t run_seed(const SimulatedUnit& unit, int run);

/// The `number`-th unit, from 1, of the lab that `config.seed` names; independent of how many units there are.
[[nodiscard]] SimulatedUnit draw_unit(const CampaignConfig& config, int number);

/// Bias that one power-on adds to a sensor for the whole run, rad/s or m/s².
[[nodiscard]] double power_on_offset(const CampaignConfig& config, const SimulatedUnit& unit, int run,
                                     calib::Sensor sensor);

/// What temperature decides of a sensor.
struct SensorAtTemperature {
  double bias = 0.0;   ///< mean over power-ons
  double scale = 1.0;  ///< 1 + scale_ppm·1e-6
};

[[nodiscard]] SensorAtTemperature at_temperature(const SimulatedSensor& truth, double temp_c);

/// The measurement equation without power-on offset and noise, for a sensor at a temperature that is known already.
[[nodiscard]] double reading_of(const SimulatedSensor& truth, const SensorAtTemperature& state, calib::Sensor sensor,
                                const calib::Vector3& force_mps2, const calib::Vector3& rate_rps);

/// Noise-free reading of a sensor at `temp_c` without its power-on offset, for specific force `force_mps2` and rotation
/// `rate_rps` in body axes.
[[nodiscard]] double ideal_reading(const SimulatedUnit& unit, calib::Sensor sensor, double temp_c,
                                   const calib::Vector3& force_mps2, const calib::Vector3& rate_rps);

}  // namespace soak::hal::sim
