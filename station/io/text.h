// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

/// Texts and dates that people enter.
namespace soak::station {

/// Fails (bad_input, at `where`) for an empty or blank text, and for one that is not base::is_plain_line(): names,
/// reasons and labels appear in tables, records and signed texts, where texts that look the same must be the same.
[[nodiscard]] base::Status check_text_line(std::string_view text, std::string_view where);

/// Longest text in a calibration file, in bytes (docs/blob-format.md).
inline constexpr std::size_t kLongestCarried = 255;

/// The same for a text that is written to calibration files (serial numbers, certificates), which must not be too long.
[[nodiscard]] base::Status check_carried_line(std::string_view text, std::string_view where);

/// Unix time at which the UTC day "2027-03-01" begins; nothing for a text that is no day of the years 1970 to 9999.
[[nodiscard]] std::optional<double> parse_iso_date(std::string_view text);

/// The UTC day of a Unix time: "2027-03-01"; outside the years 1970 to 9999 the number of seconds.
[[nodiscard]] std::string iso_date(double utc_s);

/// A text as the name of a file: letters, digits and ".-_" only, neither a dot nor a dash first.
[[nodiscard]] std::string plain_file_name(std::string_view text);

/// The same with A to Z as a to z: names that differ in nothing else are one file on some systems.
[[nodiscard]] std::string lower_case(std::string text);

}  // namespace soak::station
