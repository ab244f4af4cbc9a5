// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/hidden_effects.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {

using calib::Sensor;

ActiveEffect::ActiveEffect(const DrawnEffect& drawn, double amplitude, const EffectSurroundings& surroundings)
    : seed_(drawn.seed), spread_(surroundings.amplitude_spread) {
  EffectOrder order;
  order.amplitude = amplitude;
  order.seed = base::hashed(drawn.seed, stream_of(Purpose::hidden_chance), 0);
  order.earth = surroundings.earth;
  order.set_points_c = surroundings.set_points_c;
  const bool in_sensor_unit = drawn.entry->unit.starts_with('*');
  for (const Sensor sensor : drawn.sensors) {
    const double si = in_sensor_unit ? 1.0 / calib::printed_per_si(sensor) : 1.0;
    gain_[calib::index_of(sensor)] = si * amplitude_of(drawn, sensor, amplitude);
  }
  order.gain = gain_;
  ShapeDraws draws(base::Random(drawn.seed, stream_of(Purpose::hidden_shape)));
  effect_ = drawn.entry->make(order, draws);
  shape_ = draws.parameters();
}

double ActiveEffect::strength(int mounting) const {
  const double normal =
      base::hashed_gaussian(seed_, stream_of(Purpose::hidden_strength), static_cast<std::uint64_t>(mounting));
  return std::clamp(1.0 + spread_ * normal, 0.1, 1.9);
}

void ActiveEffect::advance_to(Conditions& now) {
  strength_ = strength(now.mounting);
  effect_->advance_to(now);
  now.element_c += strength_ * effect_->element_shift_c();
}

double ActiveEffect::addition(Sensor sensor) const {
  const double gain = gain_[calib::index_of(sensor)];
  return gain == 0.0 ? 0.0 : strength_ * gain * effect_->response(sensor);
}

double ActiveEffect::noise_factor(Sensor sensor) const {
  return gain_[calib::index_of(sensor)] == 0.0 ? 1.0 : std::pow(effect_->noise_factor(), strength_);
}

double ActiveEffect::output(Sensor sensor, double value) const {
  return gain_[calib::index_of(sensor)] == 0.0 ? value : effect_->output(sensor, value);
}

void HiddenEffects::add(const DrawnEffect& drawn, double amplitude, const EffectSurroundings& surroundings) {
  effects_.push_back(std::make_unique<ActiveEffect>(drawn, amplitude, surroundings));
  const bool moves_elements = drawn.entry->name == "sensor_lag";
  order_.insert(moves_elements ? order_.begin() : order_.end(), effects_.back().get());
}

void HiddenEffects::advance_to(Conditions now) {
  now.element_c = now.thermometer_c;
  for (ActiveEffect* effect : order_) effect->advance_to(now);
  element_c_ = now.element_c;
}

double HiddenEffects::sensed(Sensor sensor, double reading, double noise) const {
  double value = reading;
  double factor = 1.0;
  for (const ActiveEffect* effect : order_) {
    value += effect->addition(sensor);
    factor *= effect->noise_factor(sensor);
  }
  return value + factor * noise;
}

double HiddenEffects::output(Sensor sensor, double value) const {
  for (const ActiveEffect* effect : order_) value = effect->output(sensor, value);
  return value;
}

}  // namespace soak::hal::sim
