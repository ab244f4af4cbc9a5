// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace soak::station {

/// Drawings of one sensor of a report, as HTML figures; `sensor` is its entry in the section `sensors`.

/// The deployed bias curve with both its bands, and the rows that it was fitted to.
[[nodiscard]] std::string curve_chart(std::string_view name, const nlohmann::json& sensor);

/// Rows less the curve over two panels: as they are, in the bands, and with each run's own offset removed. Fresh runs,
/// which no fit has seen, are drawn in the first. Empty where there are no rows.
[[nodiscard]] std::string residual_chart(std::string_view name, const nlohmann::json& sensor);

/// The deployed curve of the scale error with its band and its rows; empty where there is no such curve.
[[nodiscard]] std::string scale_chart(std::string_view name, const nlohmann::json& sensor);

/// Overlapping Allan deviation with its interval, of the sensors whose name begins with `kind` ("gyro", "accel");
/// `sensors`: the member of the section `noise`. Empty where there is none.
[[nodiscard]] std::string allan_chart(std::string_view kind, const nlohmann::json& sensors);

/// Class of the colour of a run, or of an axis.
[[nodiscard]] std::string colour(std::size_t index);

}  // namespace soak::station
