// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "calib/signal/allan/allan_fit.h"
#include "calib/vocabulary/sensor.h"

namespace soak::nav {

/// How a bias that is left in the readings moves: about its value at the start as a first-order Gauss-Markov process
/// [AH05 §3.3.1], and beside it as a random walk. U is rad/s or m/s².
struct BiasModel {
  double start_sigma = 0.0;                                 ///< of the value at the start, in U
  double sigma = 0.0;                                       ///< of the Gauss-Markov process when it is settled, in U
  double time_s = std::numeric_limits<double>::infinity();  ///< its correlation time; infinite: no such process
  double walk = 0.0;                                        ///< random walk in U/sqrt(s)
};

/// What a filter takes for granted of one sensor's errors.
struct SensorModel {
  double white = 0.0;  ///< angle or velocity random walk in U·sqrt(s): the root of the two-sided density, U/sqrt(Hz)
  BiasModel bias;
  double scale_sigma = 0.0;  ///< of the scale factor error, 1 = 100 %; used with scale states only
};

/// Of all sensors, by index_of().
using SensorModels = std::array<SensorModel, calib::kSensorCount>;

/// The same model for the three gyros and the same for the three accelerometers.
[[nodiscard]] SensorModels same_for_axes(const SensorModel& gyro, const SensorModel& accel);

/// Whether the value about which a bias moves was measured.
enum class StartOfBias : std::uint8_t { known, unknown };

/// The model that noise coefficients say: N is the white noise (not found: what could have stayed hidden), K the random
/// walk, the Gauss-Markov term the bias; without such a term the flat part is (σ = 0.664 B over the averaging time of
/// the least deviation). A process faster than 10 s is white noise, of density 2 σ² T. One that moves about a value
/// which nobody knows is a random walk, of 2 σ²/T: a state that tends to the wrong value would take it for the bias. A
/// curve that only falls may hide a random walk that comes as far as its end in that time. `start_sigma` in U: what is
/// not known of the bias at the start.
[[nodiscard]] SensorModel sensor_model_of(const calib::signal::AllanFit& fit, double start_sigma, StartOfBias start);

}  // namespace soak::nav
