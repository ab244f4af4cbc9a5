// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/curve/calibration.h"
#include "calib/vocabulary/warning.h"

/// What temperature does to a unit without satellite navigation, each sensor alone.
namespace soak::station {

/// A course of temperature in °C: at power-on, and afterwards.
struct TemperatureCourse {
  double from_c = 0.0;
  double to_c = 0.0;
};

/// From the lowest to the highest temperature at which all sensors were calibrated; absent where these are fewer than
/// two.
[[nodiscard]] std::optional<TemperatureCourse> whole_range(const calib::Calibration& calibration);

/// Position errors by eq. 6.5 and 6.6 of [AH05] from what temperature adds to each bias between power-on at `from_c`
/// and `to_c`, with and without the calibration, as if the sensor's axis lay horizontally. Members `from_c`, `to_c`,
/// `free_inertial` and `warnings` of docs/schema/nav-impact.schema.json. The power-on constant is removed at `from_c`.
[[nodiscard]] nlohmann::json impact_json(const calib::Calibration& calibration, const TemperatureCourse& course);

/// The same over whole_range(); null where there is none.
[[nodiscard]] nlohmann::json impact_json(const calib::Calibration& calibration);

/// `free_inertial` as a table.
[[nodiscard]] std::string free_inertial_text(const nlohmann::json& sensors);

/// `one_run`, where the half-widths of a sensor cannot hold what differs between power-ons.
[[nodiscard]] std::vector<calib::Warning> scatter_warnings(const calib::Calibration& calibration);

/// impact_json() over the whole range, with `drives`: unit_drives_json() (unit_drives.h), or null and the warning
/// `drives_not_simulated` where that fails. Null where there is no range.
[[nodiscard]] nlohmann::json impact_with_drives_json(const calib::Calibration& calibration);

}  // namespace soak::station
