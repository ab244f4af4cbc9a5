// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/hidden_config.h"

#include <fmt/format.h>

#include <algorithm>

#include "hal/sim/effects/catalogue.h"

namespace soak::hal::sim {
namespace {

constexpr settings::Limits kHiddenAmplitude = {-1e6, 1e6};
constexpr settings::Limits kHiddenMagnitude = {1e-6, 1e4};

std::string known_effect_names() {
  std::string names;
  for (const CatalogueEntry& entry : catalogue()) names += fmt::format("{}{}", names.empty() ? "" : ", ", entry.name);
  return names;
}

void read_hidden_sensors(const settings::Table& table, const CatalogueEntry& entry, HiddenSpec& spec) {
  const auto names = table.texts("sensors");
  if (names.empty() && table.has("sensors")) table.refuse("sensors", "'sensors' must be a list of texts");
  for (const std::string& name : names) {
    const auto sensor = calib::sensor_named(name);
    if (!sensor) {
      table.refuse("sensors", fmt::format("'{}' in 'sensors' is not a sensor: gyro_x ... accel_z", name));
    } else if (!can_choose_sensors(entry.hits) || !can_hit(entry.hits, *sensor)) {
      table.refuse("sensors", fmt::format("effect '{}' cannot be given '{}': it acts on {}", entry.name, name,
                                          description_of(entry.hits)));
    } else {
      spec.sensors.push_back(*sensor);
    }
  }
}

HiddenSpec read_hidden_effect(const settings::Table& table) {
  HiddenSpec spec;
  spec.effect = table.text("effect");
  spec.magnitude = table.optional_number("magnitude", kHiddenMagnitude);
  spec.amplitude = table.optional_number("amplitude", kHiddenAmplitude);
  spec.seed = static_cast<std::uint64_t>(table.large_whole("seed", {0.0, 9e18}));
  const CatalogueEntry* entry = catalogue_entry(spec.effect);
  if (entry) {
    read_hidden_sensors(table, *entry, spec);
  } else {
    table.refuse("effect",
                 fmt::format("'{}' in 'effect' is not one of the effects {}", spec.effect, known_effect_names()));
    static_cast<void>(table.texts("sensors"));
  }
  if (spec.magnitude.has_value() == spec.amplitude.has_value()) {
    table.refuse("effect", "an effect needs either 'magnitude' or 'amplitude'");
  }
  const bool signless = entry && entry->amplitude_sign == AmplitudeSign::positive;
  if (spec.amplitude && (*spec.amplitude == 0.0 || (signless && *spec.amplitude < 0.0))) {
    table.refuse("amplitude", fmt::format("'amplitude' must be {}", signless ? "above 0" : "other than 0"));
  }
  return spec;
}

}  // namespace

std::vector<HiddenSpec> read_hidden(const settings::Table& root, std::string_view name) {
  std::vector<HiddenSpec> specs;
  for (const settings::Table& table : root.tables(name)) specs.push_back(read_hidden_effect(table));
  return specs;
}

}  // namespace soak::hal::sim
