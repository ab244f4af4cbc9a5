// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "station/records/check_standard.h"

namespace soak::station {

/// docs/schema/check-chart.schema.json
[[nodiscard]] nlohmann::json check_document(const std::vector<CheckChart>& charts);

}  // namespace soak::station
