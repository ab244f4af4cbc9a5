// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

/// What the columns of a recording are called and measured in.
namespace soak::station {

/// What a column of a CSV file is for.
enum class ColumnRole : std::uint8_t {
  time,       ///< t_s, t_ms, t_us
  run,        ///< label of the run, kept as metadata
  phase,      ///< soak, ramp
  sweep,      ///< up, down
  position,   ///< label of an attitude
  number,     ///< a known quantity
  auxiliary,  ///< any other: kept as it is, numbers or text
};

/// What a header cell says.
struct HeaderMeaning {
  ColumnRole role = ColumnRole::auxiliary;
  std::string name;    ///< canonical channel name: gyro_x, temp_c, position...; an unknown header's own text
  std::string unit;    ///< "s", "c", "k", "f", "dps", "rps", "degph", "mps2", "g", "mg", "v", "label", ""
  double scale = 1.0;  ///< of the time axis alone: seconds per unit of the header

  bool operator==(const HeaderMeaning&) const = default;
};

/// Reads a header cell of the form `quantity_unit`. A header that is not ours is an auxiliary channel. Fails
/// (bad_input) for one that looks like a sensor but has no unit that we know.
[[nodiscard]] base::Result<HeaderMeaning> meaning_of_header(std::string_view header);

/// The header under which a canonical channel is written in canonical units: `gx_dps` for `gyro_x`.
[[nodiscard]] std::string canonical_header(std::string_view channel_name);

/// Converts one value from a channel's unit to another.
using Conversion = double (*)(double);

/// From the unit of a channel ("rps", "degph", "mg", "k"...) to the inside of the programs: rad/s, m/s², °C. A unit
/// that has no other form ("s", "v", "") stays.
[[nodiscard]] Conversion conversion_to_si(std::string_view unit);

/// From the unit of a channel to that of canonical CSV columns: deg/s, m/s², °C. A value in that unit already is
/// untouched, to the bit.
[[nodiscard]] Conversion conversion_to_csv(std::string_view unit);

}  // namespace soak::station
