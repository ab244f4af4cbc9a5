// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/sensor_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace soak::nav {
namespace {

/// Over the tens of seconds of an outage a process faster than this is white noise of its density at low frequencies.
constexpr double kShortProcess_s = 10.0;

}  // namespace

SensorModels same_for_axes(const SensorModel& gyro, const SensorModel& accel) {
  return {gyro, gyro, gyro, accel, accel, accel};
}

SensorModel sensor_model_of(const calib::signal::AllanFit& fit, double start_sigma, StartOfBias start) {
  const auto& noise = fit.angle_random_walk;
  double white2 = std::pow(noise.found ? noise.value : noise.high, 2);
  double walk2 = std::pow(fit.rate_random_walk.value, 2);
  SensorModel model;
  model.bias.start_sigma = start_sigma;
  const double flat = std::sqrt(2.0 * std::numbers::ln2 / std::numbers::pi) * fit.bias_instability.value;
  const double tau_s = fit.bias_instability_tau_s;
  const bool has_process = fit.markov_sigma.found || (fit.bias_instability.found && tau_s > 0.0);
  const double sigma = fit.markov_sigma.found ? fit.markov_sigma.value : flat;
  const double time_s = fit.markov_sigma.found ? fit.markov_time_s.value : tau_s;
  if (!has_process) {
    // A random walk that comes to the end of the falling curve in that time.
    if (tau_s > 0.0) walk2 = std::max(walk2, flat * flat / tau_s);
  } else if (time_s < kShortProcess_s) {
    white2 += 2.0 * sigma * sigma * time_s;
  } else if (start == StartOfBias::known) {
    model.bias.sigma = sigma;
    model.bias.time_s = time_s;
  } else {
    walk2 += 2.0 * sigma * sigma / time_s;
  }
  model.white = std::sqrt(white2);
  model.bias.walk = std::sqrt(walk2);
  return model;
}

}  // namespace soak::nav
