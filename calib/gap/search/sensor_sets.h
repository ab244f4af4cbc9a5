// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "calib/vocabulary/sensor.h"

namespace soak::calib::gap {

/// Sets of sensors that a mechanism may act on together: all of those given, their gyros, their accelerometers, and
/// each alone; none empty, none twice.
[[nodiscard]] std::vector<std::vector<Sensor>> sensor_sets(const std::vector<Sensor>& sensors);

/// Chance that independent chances are as small together as those given (Fisher): −2 Σ ln p is χ² with two degrees of
/// freedom for each. 1 for none.
[[nodiscard]] double chance_together(std::span<const double> chances);

}  // namespace soak::calib::gap
