// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "hal/sim/effects/catalogue.h"

namespace soak::hal::sim::test {

/// An effect by itself, with the shape that was drawn for it.
struct LoneEffect {
  std::unique_ptr<Effect> effect;
  std::vector<ShapeParameter> parameters;

  explicit LoneEffect(const std::string& name, double amplitude = 1.0, std::uint64_t seed = 1) {
    EffectOrder order;
    order.gain.fill(amplitude);
    order.amplitude = amplitude;
    order.seed = seed;
    order.set_points_c = {-20.0, -5.0, 10.0, 25.0, 40.0, 55.0, 70.0};
    ShapeDraws shape{base::Random(seed)};
    effect = catalogue_entry(name)->make(order, shape);
    parameters = shape.parameters();
  }

  [[nodiscard]] double shape(const std::string& name) const {
    for (const ShapeParameter& parameter : parameters) {
      if (parameter.name == name) return parameter.value;
    }
    throw std::runtime_error("no shape parameter " + name);
  }

  /// Response of a sensor after going on to `now`.
  double at(const Conditions& now, calib::Sensor sensor = calib::Sensor::gyro_x) {
    effect->advance_to(now);
    return effect->response(sensor);
  }
};

/// Conditions of a powered unit at a uniform temperature.
inline Conditions at_rest(double time_s, double temp_c, const calib::Vector3& up = {0.0, 0.0, 1.0}) {
  Conditions now;
  now.time_s = now.since_power_on_s = time_s;
  now.utc_s = kFirstUtc_s + time_s;
  now.powered = true;
  now.thermometer_c = now.element_c = now.air_c = temp_c;
  now.up = up;
  now.supply_v = 5.0;
  return now;
}

}  // namespace soak::hal::sim::test
