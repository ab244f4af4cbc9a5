// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/temperature_controller.h"

#include <algorithm>

namespace soak::hal::sim {

TemperatureController::TemperatureController(const ControllerMagnitudes& magnitudes, double start_c)
    : magnitudes_(magnitudes), set_point_c_(start_c), working_c_(start_c), sensed_c_(start_c) {}

void TemperatureController::switch_control(bool on) {
  if (on && !on_) {
    integral_ = 0.0;
    starting_ = ramp_.at_start;
    working_c_ = starting_ ? sensed_c_ : set_point_c_;
  }
  if (!on) output_ = 0.0;
  on_ = on;
}

void TemperatureController::move_working_set_point(double dt_s) {
  const bool ramps = ramp_.at_set_point || starting_;
  const double step_c = ramp_.rate_kps * dt_s;
  working_c_ = ramps ? std::clamp(set_point_c_, working_c_ - step_c, working_c_ + step_c) : set_point_c_;
  if (working_c_ == set_point_c_) starting_ = false;
}

void TemperatureController::step(double dt_s, double air_c) {
  sensed_c_ += dt_s / magnitudes_.sensor_lag_s * (air_c - sensed_c_);
  if (!on_) return;
  move_working_set_point(dt_s);
  const double proportional = magnitudes_.gain_pk * (working_c_ - sensed_c_);
  const double unlimited = proportional + integral_;
  output_ = std::clamp(unlimited, -1.0, 1.0);
  // The integral rests while the output is at its limit: it would only be wound up.
  if (output_ == unlimited) integral_ += dt_s / magnitudes_.integral_time_s * proportional;
}

}  // namespace soak::hal::sim
