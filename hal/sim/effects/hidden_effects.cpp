// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/hidden_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/random.h"
#include "hal/sim/campaign/run_plan.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {

using calib::Sensor;

namespace {

/// Two effects of the same seed share nothing.
std::uint64_t seed_of(const HiddenSpec& spec) {
  std::uint64_t seed = spec.seed;
  for (const char letter : spec.effect) seed = base::hashed(seed, 0, static_cast<unsigned char>(letter));
  return seed;
}

std::vector<Sensor> sensors_of_kind(bool gyros) {
  const auto first = calib::kSensors.begin() + (gyros ? 0 : 3);
  return {first, first + 3};
}

Sensor one_of(const std::vector<Sensor>& sensors, base::Random& random) {
  return sensors[static_cast<std::size_t>(random.uniform() * static_cast<double>(sensors.size()))];
}

std::vector<Sensor> drawn_sensors(Hits hits, base::Random& random) {
  std::vector<Sensor> everything(calib::kSensors.begin(), calib::kSensors.end());
  const double dice = random.uniform();
  switch (hits) {
    case Hits::all:
      return everything;
    case Hits::all_gyros:
    case Hits::all_accels:
      return sensors_of_kind(hits == Hits::all_gyros);
    case Hits::some_gyros:
    case Hits::some_accels: {
      const std::vector<Sensor> three = sensors_of_kind(hits == Hits::some_gyros);
      return dice < 0.5 ? std::vector<Sensor>{one_of(three, random)} : three;
    }
    case Hits::some:
      break;
  }
  if (dice < 0.4) return {one_of(everything, random)};
  if (dice < 0.8) return sensors_of_kind(dice < 0.6);
  return everything;
}

/// A weight for each of `count` sensors; the largest is 1.
std::vector<double> drawn_weights(std::size_t count, base::Random& random) {
  std::vector<double> weights(count);
  double largest = 0.0;
  for (double& weight : weights) {
    weight = drawn_sign(random) * random.uniform(0.5, 1.0);
    largest = std::max(largest, std::abs(weight));
  }
  for (double& weight : weights) weight /= largest;
  return weights;
}

}  // namespace

DrawnEffect draw_effect(const HiddenSpec& spec, int number, double mps2_per_dps) {
  DrawnEffect drawn;
  drawn.entry = catalogue_entry(spec.effect);
  drawn.seed = base::hashed(seed_of(spec), stream_of(Purpose::hidden_shape), static_cast<std::uint64_t>(number));
  base::Random random(drawn.seed, stream_of(Purpose::hidden_sensors));
  drawn.sensors = spec.sensors.empty() ? drawn_sensors(drawn.entry->hits, random) : spec.sensors;
  std::sort(drawn.sensors.begin(), drawn.sensors.end());
  const bool weighted = drawn.entry->weighted && spec.magnitude.has_value();
  const std::vector<double> weights =
      weighted ? drawn_weights(drawn.sensors.size(), random) : std::vector<double>(drawn.sensors.size(), 1.0);
  // Of one kind of sensor, or of an effect whose amplitude is in the unit of no sensor, no kind needs another weight.
  const bool both_kinds = calib::is_gyro(drawn.sensors.front()) && drawn.entry->unit.starts_with('*');
  for (std::size_t i = 0; i < drawn.sensors.size(); ++i) {
    const Sensor sensor = drawn.sensors[i];
    const double kind = both_kinds && !calib::is_gyro(sensor) ? mps2_per_dps : 1.0;
    drawn.weight[calib::index_of(sensor)] = kind * weights[i];
  }
  return drawn;
}

double amplitude_of(const DrawnEffect& drawn, Sensor sensor, double amplitude) {
  return amplitude * drawn.weight[calib::index_of(sensor)];
}

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

std::vector<LabEffect> lab_effects(const CampaignConfig& config, int number) {
  const double accel_weight = mps2_per_dps(config.design.value_or(default_design(DesignKind::identical)));
  std::vector<LabEffect> effects;
  for (const HiddenSpec& spec : config.hidden) {
    effects.push_back({draw_effect(spec, number, accel_weight), spec.amplitude.value_or(0.0)});
  }
  return effects;
}

EffectSurroundings lab_surroundings(const CampaignConfig& config) {
  EffectSurroundings surroundings{config.earth, {}};
  for (const SetPoint& point : campaign_set_points(config)) {
    if (point.sweep == calib::Sweep::up) surroundings.set_points_c.push_back(point.temp_c);
  }
  return surroundings;
}

std::string shape_json(const std::vector<ShapeParameter>& shape) {
  std::string text = "{";
  std::string_view separator;
  for (const ShapeParameter& parameter : shape) {
    text += fmt::format("{}\"{}\": {:.7g}", separator, parameter.name, parameter.value);
    separator = ", ";
  }
  return text + "}";
}

}  // namespace soak::hal::sim
