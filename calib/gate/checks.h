// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "calib/gate/view.h"

/// The checks of the data gate, each in a file of its own. A new one is a file, a declaration and an entry of
/// `kChecks`.
namespace soak::calib::gate {

/// Appends what it found in a segment; `findings` holds those of the checks before it.
using Check = void (*)(const View& view, std::vector<Finding>& findings);

/// Direction of the specific force between stretches, and angles that the gyros turn through.
void moved(const View& view, std::vector<Finding>& findings);
/// Bursts in several sensors at once. Silent where the unit has moved: that explains them.
void knocked(const View& view, std::vector<Finding>& findings);
/// Mean specific force against the position's up vector.
void wrong_position(const View& view, std::vector<Finding>& findings);
/// Samples at the range of the type, or piled up at the extreme value.
void saturated(const View& view, std::vector<Finding>& findings);
/// The same value bit for bit for longer than chance allows. Silent where the sensor is saturated.
void stuck(const View& view, std::vector<Finding>& findings);
/// Share of samples that are missing.
void dropouts(const View& view, std::vector<Finding>& findings);
/// Intervals that differ from the usual one. Silent where samples are missing.
void irregular_sampling(const View& view, std::vector<Finding>& findings);
/// Steps of the thermometers.
void coarse_thermometer(const View& view, std::vector<Finding>& findings);

inline constexpr std::array<Check, 8> kChecks = {
    moved, knocked, wrong_position, saturated, stuck, dropouts, irregular_sampling, coarse_thermometer,
};

}  // namespace soak::calib::gate
