// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/effect_text.h"

#include <fmt/format.h>

#include <string_view>

#include "hal/sim/effects/lab_effects.h"

namespace soak::hal::sim {
namespace {

std::string lab_effect_json(const DrawnEffect& drawn, double amplitude, const EffectSurroundings& surroundings) {
  std::string sensors;
  for (const calib::Sensor sensor : drawn.sensors) {
    sensors +=
        fmt::format("{}\"{}\": {{\"amplitude\": {:.7g}, \"unit\": \"{}\"}}", sensors.empty() ? "" : ", ",
                    calib::name_of(sensor), amplitude_of(drawn, sensor, amplitude), unit_of(*drawn.entry, sensor));
  }
  const ActiveEffect active(drawn, amplitude, surroundings);
  return fmt::format("{{\"name\": \"{}\", \"nameable\": {}, \"sensors\": {{{}}}, \"shape\": {}}}", drawn.entry->name,
                     drawn.entry->nameable, sensors, shape_json(active.shape()));
}

}  // namespace

std::string shape_json(const std::vector<ShapeParameter>& shape) {
  std::string text = "{";
  std::string_view separator;
  for (const ShapeParameter& parameter : shape) {
    text += fmt::format("{}\"{}\": {:.7g}", separator, parameter.name, parameter.value);
    separator = ", ";
  }
  return text + "}";
}

std::string lab_effects_json(const CampaignConfig& config, int number) {
  std::string text = "[";
  std::string_view separator;
  for (const LabEffect& effect : lab_effects(config, number)) {
    text += separator;
    text += lab_effect_json(effect.drawn, effect.amplitude, lab_surroundings(config));
    separator = ", ";
  }
  return text + "]";
}

}  // namespace soak::hal::sim
