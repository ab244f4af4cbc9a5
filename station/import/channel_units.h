// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace soak::station {

/// Converts one value from a channel's unit to another.
using Conversion = double (*)(double);

/// From the unit of a channel ("rps", "degph", "mg", "k"...) to the inside of the programs: rad/s, m/s², °C. A unit
/// that has no other form ("s", "v", "") stays.
[[nodiscard]] Conversion conversion_to_si(std::string_view unit);

/// From the unit of a channel to that of canonical CSV columns: deg/s, m/s², °C. A value in that unit already is
/// untouched, to the bit.
[[nodiscard]] Conversion conversion_to_csv(std::string_view unit);

}  // namespace soak::station
