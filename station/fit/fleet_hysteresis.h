// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <set>
#include <string>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/sensor.h"
#include "db/catalog/catalog.h"

/// What a fleet shows of thermal hysteresis, for units that were recorded one way.
namespace soak::station {

/// Half the gap between heating and cooling of each sensor; source `none` where no unit shows it.
using FleetHysteresis = std::array<calib::KnownHysteresis, calib::kSensorCount>;

/// Whether rows went one way somewhere, the unit's type states no hysteresis, and its other units may show one.
[[nodiscard]] bool asks_fleet(const calib::UnitRows& rows);

/// Whether the hysteresis of some sensor of a model came from the fleet, or would have, had the fleet shown one.
[[nodiscard]] bool asked_fleet(const calib::Calibration& calibration);

/// Whether a model that asked the fleet has what it shows now.
[[nodiscard]] bool agrees(const calib::Calibration& calibration, const FleetHysteresis& fleet);

/// Root mean square of half the gaps of all units of a type that went both ways, each by its newest model; none that
/// asked the fleet itself counts, and none of `without`: the unit that asks. What was simulated says nothing of real
/// units. Fails (corrupt) for a damaged model.
[[nodiscard]] base::Result<FleetHysteresis> hysteresis_of_fleet(const db::Catalog& catalog, const std::string& type,
                                                                bool simulated, const std::set<std::string>& without);

/// Gives the rows what they ask for: nothing else of them changes.
void take_from_fleet(const FleetHysteresis& fleet, calib::UnitRows& rows);

}  // namespace soak::station
