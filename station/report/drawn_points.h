// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace soak::station {

/// The points of each sensor that its figures draw beside its curves, in lists, with as many digits as a drawing can
/// show: `sensors` of docs/schema/http-model-rows.schema.json. `sensors` is that section of a report
/// (docs/schema/report.schema.json).
[[nodiscard]] nlohmann::json drawn_points(const nlohmann::json& sensors);

}  // namespace soak::station
