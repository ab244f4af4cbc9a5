// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// Units of a type that are compared (the last ones by serial number), and those whose curves are in the document, at
/// most.
inline constexpr std::size_t kMostUnitsOfFleet = 1000;
inline constexpr std::size_t kMostCurvesDrawn = 200;

/// How the catalog is reached, and what is known of a unit beside it.
struct FleetSources {
  using Work = std::function<base::Result<nlohmann::json>(const db::Catalog&)>;
  /// Calls the work with the catalog when it is its turn.
  std::function<base::Result<nlohmann::json>(const Work&)> in_turn;
  /// The verdict that holds for a unit (`unit`, `epoch`, `model`: its head in docs/schema/http-fleet.schema.json), or
  /// null.
  std::function<base::Result<nlohmann::json>(const db::Catalog&, const nlohmann::json& unit)> verdict;
};

/// The newest models of all units of a type beside each other (docs/schema/http-fleet.schema.json): verdicts, and of
/// each sensor median, spread, outliers and drift as calib::compare_fleet() has them. Reads the curves that models
/// state and calculates none. A few units take a turn, so that others get theirs between them. Refuses (bad_input,
/// where == "type") a type that no unit is of. A unit whose model cannot be read has the reason as `trouble` and no
/// part in the curves; one whose verdict cannot be told, as `trouble` only; of one whose model before cannot be read,
/// or that has a model of one run, no drift is told.
[[nodiscard]] base::Result<nlohmann::json> fleet_overview(const FleetSources& sources, const std::string& type);

}  // namespace soak::station
