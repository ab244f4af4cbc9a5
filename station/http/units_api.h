// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "station/http/runs_api.h"

namespace soak::station {

/// Questions about one unit that no job has a part in: versions of its model, the rows behind them, what a calibration
/// buys, noise. docs/http-api.md.
[[nodiscard]] const std::vector<RunQuestion>& unit_questions();

}  // namespace soak::station
