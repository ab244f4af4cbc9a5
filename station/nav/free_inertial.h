// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calib/curve/calibration.h"
#include "calib/vocabulary/warning.h"

/// What temperature does to a unit without satellite navigation, each sensor alone.
namespace soak::station {

/// Position errors by eq. 6.5 and 6.6 of [AH05] from what temperature adds to each bias between power-on at `from_c`
/// and `to_c` (°C), with and without the calibration, as if the sensor's axis lay horizontally: `free_inertial` of
/// docs/schema/nav-impact.schema.json. The power-on constant is removed at `from_c`.
[[nodiscard]] nlohmann::json free_inertial_json(const calib::Calibration& calibration, double from_c, double to_c);

/// The same as a table.
[[nodiscard]] std::string free_inertial_text(const nlohmann::json& sensors);

/// `one_run`, where the half-widths of a sensor cannot hold what differs between power-ons.
[[nodiscard]] std::vector<calib::Warning> scatter_warnings(const calib::Calibration& calibration);

}  // namespace soak::station
