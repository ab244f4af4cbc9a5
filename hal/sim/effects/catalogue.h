// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Which sensors an effect can hit: one, three or six of those that its physics allows, or all of them at once.
enum class Hits : std::uint8_t { some, some_gyros, some_accels, all_gyros, all_accels, all };

/// How the magnitude of an effect is counted; design/detail/effect_size.h has the definitions.
enum class Measure : std::uint8_t { blocks, curve, runs, block_noise, row_noise, clipped_share };

/// Whether a negative amplitude means anything.
enum class AmplitudeSign : std::uint8_t { any, positive };

/// An effect that can be hidden.
struct CatalogueEntry {
  std::string_view name;
  std::string_view unit;  ///< of the amplitude; "*" stands for the printed unit of the sensor
  Hits hits;
  bool nameable;  ///< in the list of names that the gap workflow knows
  bool weighted;  ///< sensors differ in amplitude where the magnitude is given
  EffectMaker make;
  Measure measure = Measure::blocks;
  AmplitudeSign amplitude_sign = AmplitudeSign::any;
};

/// All effects; catalogue.cpp says the physics of each.
[[nodiscard]] std::span<const CatalogueEntry> catalogue();
/// The effect of a name; null for another text.
[[nodiscard]] const CatalogueEntry* catalogue_entry(std::string_view name);

[[nodiscard]] bool can_hit(Hits hits, calib::Sensor sensor);
/// Whether a configuration may name the sensors.
[[nodiscard]] bool can_choose_sensors(Hits hits);
/// For messages: "gyros"...
[[nodiscard]] std::string_view description_of(Hits hits);
/// Unit of an entry's amplitude for a sensor: "deg/s per V".
[[nodiscard]] std::string unit_of(const CatalogueEntry& entry, calib::Sensor sensor);

}  // namespace soak::hal::sim
