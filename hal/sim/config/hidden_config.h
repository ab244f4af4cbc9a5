// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "settings/reader.h"

namespace soak::hal::sim {

/// One effect that [[hidden]] or [[candidate]] asks for. Exactly one of `magnitude` and `amplitude` is given.
struct HiddenSpec {
  std::string effect;                  ///< a name of the catalogue (effects/catalogue.h)
  std::optional<double> magnitude;     ///< how hard it is to see in the planned campaign (blind/effect_size.h), above 0
  std::optional<double> amplitude;     ///< how large it is, in the unit of the effect; not 0
  std::uint64_t seed = 0;              ///< of the sensors that are hit, of the shape, of what happens by chance
  std::vector<calib::Sensor> sensors;  ///< that are hit; empty = drawn
};

/// Reads the tables [[`name`]], hidden or candidate, none where there are none; mistakes are recorded in it.
[[nodiscard]] std::vector<HiddenSpec> read_hidden(const settings::Table& root, std::string_view name);

}  // namespace soak::hal::sim
