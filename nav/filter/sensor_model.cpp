// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/sensor_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace soak::nav {

SensorModels same_for_axes(const SensorModel& gyro, const SensorModel& accel) {
  return {gyro, gyro, gyro, accel, accel, accel};
}

SensorModel sensor_model_of(const calib::signal::AllanFit& fit, double start_sigma) {
  SensorModel model;
  model.white = fit.angle_random_walk.found ? fit.angle_random_walk.value : fit.angle_random_walk.high;
  model.bias.start_sigma = start_sigma;
  model.bias.walk = fit.rate_random_walk.value;
  if (fit.markov_sigma.found) {
    model.bias.sigma = fit.markov_sigma.value;
    model.bias.time_s = fit.markov_time_s.value;
  } else if (fit.bias_instability_tau_s > 0.0) {
    const double flat = std::sqrt(2.0 * std::numbers::ln2 / std::numbers::pi) * fit.bias_instability.value;
    if (fit.bias_instability.found) {
      model.bias.sigma = flat;
      model.bias.time_s = fit.bias_instability_tau_s;
    } else {
      model.bias.walk = std::max(model.bias.walk, flat / std::sqrt(fit.bias_instability_tau_s));
    }
  }
  return model;
}

}  // namespace soak::nav
