// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace soak::base {

/// The finite number that the whole of `text` spells (decimal dot, optional sign and exponent, no locale, no blanks);
/// nothing for anything else, "nan" and "inf" included.
[[nodiscard]] std::optional<double> parse_double(std::string_view text);

/// As parse_double, rounded once from the decimal text to float32.
[[nodiscard]] std::optional<float> parse_float(std::string_view text);

/// The whole number that the whole of `text` spells.
[[nodiscard]] std::optional<std::int64_t> parse_int(std::string_view text);

/// The shortest text that reads back as exactly the same number.
[[nodiscard]] std::string shortest(double value);
[[nodiscard]] std::string shortest(float value);

/// Unix time as "2026-11-21T08:00:00Z" (Gregorian calendar, leap seconds not counted, fractions cut); for times outside
/// the years 1970 to 9999 the number of seconds.
[[nodiscard]] std::string utc_text(double unix_s);

}  // namespace soak::base
