// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/chamber_plant.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::sim {
namespace {

/// Share of full power below which the compressor rests.
constexpr double kIdleRefrigeration = 0.01;

}  // namespace

ChamberPlant::ChamberPlant(const PlantMagnitudes& magnitudes)
    : magnitudes_(magnitudes), air_c_(magnitudes.room_c), load_c_(magnitudes.room_c) {}

double ChamberPlant::compressor_cycle() const {
  return in_running_half() ? 1.0 + magnitudes_.compressor_depth : 1.0 - magnitudes_.compressor_depth;
}

bool ChamberPlant::compressor_runs() const { return in_running_half() && refrigeration_ > kIdleRefrigeration; }

void ChamberPlant::step(double dt_s, double output) {
  const PlantMagnitudes& m = magnitudes_;
  heater_ += dt_s / m.heater_lag_s * (std::max(output, 0.0) - heater_);
  refrigeration_ += dt_s / m.refrigeration_lag_s * (std::max(-output, 0.0) - refrigeration_);
  compressor_s_ = std::fmod(compressor_s_ + dt_s, m.compressor_period_s);

  const double capacity = 1.0 + m.load_to_air;
  const double power_kps = capacity * (m.heating_kps * heater_ - m.cooling_kps * refrigeration_ * compressor_cycle());
  const double from_load_kps = m.load_to_air / m.load_settling_time_s * (load_c_ - air_c_);
  const double from_room_kps = capacity / m.leak_time_s * (m.room_c - air_c_);
  const double load_kps = (air_c_ - load_c_) / m.load_settling_time_s;
  air_c_ += dt_s * (power_kps + from_load_kps + from_room_kps);
  load_c_ += dt_s * load_kps;
}

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
