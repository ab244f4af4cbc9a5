// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "station/records/check_standard.h"

namespace soak::station {

/// The charts as text: one table per sensor, one line per campaign.
[[nodiscard]] std::string check_text(const std::vector<CheckChart>& charts);

}  // namespace soak::station
