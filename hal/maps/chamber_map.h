// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <variant>

#include "base/result.h"
#include "hal/devices/chamber.h"
#include "hal/maps/device_map.h"
#include "hal/maps/text_map.h"

namespace soak::hal {

/// The controller of a device as data: over Modbus, or over lines of text. Of a chamber, but it may be of another kind.
using ChamberMap = std::variant<RegisterMap, TextMap>;

/// Reads a map of either kind: `protocol` in the file says which, Modbus where it is absent. Refuses (bad_input) all
/// mistakes at once as parse_register_map() does. A map of another kind is read as well: its `kind` tells.
[[nodiscard]] base::Result<ChamberMap> read_chamber_map(const std::string& file, MapUse use = MapUse::any);

[[nodiscard]] const std::string& name_of(const ChamberMap& map);
/// "chamber", "fixture" or "power".
[[nodiscard]] std::string kind_of(const ChamberMap& map);
/// Process time between readings.
[[nodiscard]] double poll_s(const ChamberMap& map);

/// Refuses (bad_input) a map that lacks what every chamber needs. Nothing is opened yet.
[[nodiscard]] base::Result<std::unique_ptr<Chamber>> make_chamber(const ChamberMap& map);
/// The same for unit power.
[[nodiscard]] base::Result<std::unique_ptr<UnitPower>> make_unit_power(const ChamberMap& map);

}  // namespace soak::hal
