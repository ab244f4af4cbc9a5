// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/estimate/detail/problem.h"
#include "calib/estimate/six_position.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib::six_position {

/// Says in words what the positions of a run do not show of a sensor, where it stays, and which of the six positions
/// are missing (code `missing_position`). Silent where nothing is missing, and of runs without positions.
void warn_of_missing(const Problem& problem, const SensorEstimate& estimate, std::vector<Warning>& warnings);

}  // namespace soak::calib::six_position
