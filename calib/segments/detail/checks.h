// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "calib/segments/detail/view.h"

/// The checks of the data gate, each in a file of its own.
namespace soak::calib::gate {

// Of one sensor in one segment, while its samples are in memory.

/// Samples at the range of the type, or piled up at the extreme value.
[[nodiscard]] std::optional<Finding> saturated(const Samples& samples);
/// The same value bit for bit for longer than chance allows. Not asked where the sensor is saturated.
[[nodiscard]] std::optional<Finding> stuck(const Samples& samples);
/// Time without values, of a segment.
struct Loss {
  double share = 0.0;
  double longest_s = 0.0;
};
/// Of values at `times`, usually `interval_s` apart, in a segment of these rows.
[[nodiscard]] Loss loss_of(std::span<const double> t_s, std::span<const double> times, double interval_s);
/// Share of samples that are missing.
[[nodiscard]] std::optional<Finding> dropouts(const Samples& samples, const Loss& loss);
/// Share of the intervals that differ from the usual one by more than half of it; nothing where there are too few.
[[nodiscard]] std::optional<double> share_off(std::span<const double> times, double interval_s);
/// Intervals that differ from the usual one. Not asked where samples are missing.
[[nodiscard]] std::optional<Finding> irregular_sampling(const Samples& samples, double share);

// Of a segment, from what is kept of its sensors.

/// Appends what it found; `findings` holds those of the checks before it.
using Check = void (*)(const View& view, std::vector<Finding>& findings);

/// Direction of the specific force between stretches, and angles that the gyros turn through.
void moved(const View& view, std::vector<Finding>& findings);
/// Bursts in several sensors at once. Silent where the unit has moved: that explains them.
void knocked(const View& view, std::vector<Finding>& findings);
/// Mean specific force against the position's up vector.
void wrong_position(const View& view, std::vector<Finding>& findings);
/// What was found in each sensor's samples, check by check.
void sensor_findings(const View& view, std::vector<Finding>& findings);
/// Steps of the thermometers.
void coarse_thermometer(const View& view, std::vector<Finding>& findings);

inline constexpr std::array<Check, 5> kChecks = {moved, knocked, wrong_position, sensor_findings, coarse_thermometer};

}  // namespace soak::calib::gate
