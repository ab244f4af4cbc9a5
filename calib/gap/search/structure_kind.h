// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace soak::calib::gap {

/// What kind of thing readings follow that no effect of the library explains.
enum class StructureKind : std::uint8_t {
  direction_of_sweep,        ///< heating and cooling differ
  settling,                  ///< since the plateau was reached, otherwise when heating than when cooling
  creep_after_turn,          ///< since the fixture turned
  position_order,            ///< the order of the positions in a visit
  position,                  ///< the position
  position_before,           ///< the position before
  position_and_temperature,  ///< the position, otherwise at each temperature
  drift_in_run,              ///< the time within a run, alike in all
  daily_wave,                ///< the time of day
  after_power_on,            ///< the time since power-on
  air_gradient,              ///< the chamber's air less the unit
  between_effects,           ///< between two effects of the library, and neither
  wander,                    ///< slowly in time, in another way in each run
  step,                      ///< a bias that steps in one run, and stays there
  telegraph_noise,           ///< a bias that jumps to and fro
  jumps                      ///< a bias that jumps, and nothing tells which of the two it is
};

/// Its key in documents: "creep_after_turn".
[[nodiscard]] std::string_view name_of(StructureKind kind);

/// What people are told of it.
struct StructureWords {
  std::string_view usual;  ///< what such a thing usually is, after "such readings usually come from "
  std::string_view look;   ///< where to look, after "look at "
};

/// The recordings in which such a thing was found: its words depend on them.
struct Recorded {
  bool on_ramps = false;  ///< judged by branches, without plateaus
  int runs = 0;           ///< at plateaus, that were searched
};

[[nodiscard]] StructureWords words_of(StructureKind kind, const Recorded& recorded);

}  // namespace soak::calib::gap
