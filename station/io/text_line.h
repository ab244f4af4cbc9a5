// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include "base/result.h"

namespace soak::station {

/// Refuses (bad_input, at `where`) what is empty or blank, and what is not base::is_plain_line(): names, reasons and
/// labels stand in tables, records and signed texts, where two of them that look alike must be alike.
[[nodiscard]] base::Status check_text_line(std::string_view text, std::string_view where);

/// Longest text that a calibration file carries, in bytes (docs/blob-format.md).
inline constexpr std::size_t kLongestCarried = 255;

/// The same for a text that calibration files carry (serial numbers, certificates): refuses one that is too long, too.
[[nodiscard]] base::Status check_carried_line(std::string_view text, std::string_view where);

}  // namespace soak::station
