// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/hidden_config.h"

#include <fmt/format.h>

#include <algorithm>

#include "hal/sim/config/config_reader.h"
#include "hal/sim/effects/catalogue.h"

namespace soak::hal::sim {
namespace {

constexpr ConfigReader::Limits kAmplitude = {-1e6, 1e6};
constexpr ConfigReader::Limits kMagnitude = {1e-6, 1e4};

std::string known_names() {
  std::string names;
  for (const CatalogueEntry& entry : catalogue()) names += fmt::format("{}{}", names.empty() ? "" : ", ", entry.name);
  return names;
}

void read_sensors(ConfigReader& reader, const std::string& key, const CatalogueEntry& entry, HiddenSpec& spec) {
  for (const std::string& name : reader.optional_texts(key)) {
    const auto sensor = calib::sensor_named(name);
    if (!sensor) {
      reader.refuse(key, fmt::format("'{}' in '{}' is no sensor: gyro_x ... accel_z", name, key));
    } else if (!can_choose_sensors(entry.hits) || !can_hit(entry.hits, *sensor)) {
      reader.refuse(key, fmt::format("effect '{}' cannot be given '{}': it acts on {}", entry.name, name,
                                     description_of(entry.hits)));
    } else {
      spec.sensors.push_back(*sensor);
    }
  }
}

HiddenSpec read_one(ConfigReader& reader, const std::string& table) {
  const auto key = [&](const std::string& name) { return table + "." + name; };
  HiddenSpec spec;
  spec.effect = reader.text(key("effect"));
  spec.magnitude = reader.optional_number(key("magnitude"), kMagnitude);
  spec.amplitude = reader.optional_number(key("amplitude"), kAmplitude);
  spec.seed = static_cast<std::uint64_t>(reader.whole(key("seed"), {0.0, 9e18}));
  const CatalogueEntry* entry = catalogue_entry(spec.effect);
  if (entry) {
    read_sensors(reader, key("sensors"), *entry, spec);
  } else {
    reader.refuse(key("effect"),
                  fmt::format("'{}' in '{}' is none of the effects {}", spec.effect, key("effect"), known_names()));
  }
  if (spec.magnitude.has_value() == spec.amplitude.has_value()) {
    reader.refuse(key("effect"), fmt::format("'{}' needs either 'magnitude' or 'amplitude'", table));
  }
  const bool signless = entry && entry->amplitude_sign == AmplitudeSign::positive;
  if (spec.amplitude && (*spec.amplitude == 0.0 || (signless && *spec.amplitude < 0.0))) {
    reader.refuse(key("amplitude"),
                  fmt::format("'{}' must be {}", key("amplitude"), signless ? "above 0" : "other than 0"));
  }
  return spec;
}

}  // namespace

std::vector<HiddenSpec> read_hidden(ConfigReader& reader, const std::string& table) {
  std::vector<HiddenSpec> specs;
  const std::size_t count = reader.table_count(table);
  for (std::size_t i = 0; i < count; ++i) specs.push_back(read_one(reader, fmt::format("{}[{}]", table, i)));
  return specs;
}

}  // namespace soak::hal::sim
