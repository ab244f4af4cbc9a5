// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "calib/gap/effects/effect.h"

namespace soak::calib::gap {

/// "rad/s" or "m/s2".
[[nodiscard]] std::string si_unit(Sensor sensor);
/// "x", "y", "z" of an axis, counted on cyclically.
[[nodiscard]] std::string axis_name(std::size_t axis);
/// Middle of the campaign's range of temperature, that reduced_temperature() counts from.
[[nodiscard]] double middle_c(const Observations& observations);

/// Meaning of with_temperature_shape() in one sensor: `name` at the middle of the range and, with two columns, its
/// slope against temperature. `per`: what follows the sensor's unit ("/(K/s)").
[[nodiscard]] Meaning temperature_shaped(const Circumstances& c, const Candidate& candidate, Sensor sensor,
                                         std::string_view name, std::string_view per);

}  // namespace soak::calib::gap
