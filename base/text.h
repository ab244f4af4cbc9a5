// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Texts of numbers, times and identifiers, and what text is accepted.
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

/// Value of a lower-case hexadecimal digit, -1 for any other character.
constexpr int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/// The N bytes that exactly 2·N lower-case hexadecimal digits spell; nothing for any other text.
template <std::size_t N>
constexpr std::optional<std::array<std::uint8_t, N>> bytes_of_hex(std::string_view hex) {
  std::array<std::uint8_t, N> bytes{};
  if (hex.size() != 2 * N) return std::nullopt;
  for (std::size_t i = 0; i < N; ++i) {
    const int high = hex_digit(hex[2 * i]);
    const int low = hex_digit(hex[2 * i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    bytes[i] = static_cast<std::uint8_t>(16 * high + low);
  }
  return bytes;
}

/// UUID version 7 (RFC 9562 §5.7) as text: `unix_ms` in the upper 48 bits, the rest from two random words. Sorts by
/// time of creation. The clock and the randomness are the caller's: this function is pure.
[[nodiscard]] std::string uuid_v7(std::uint64_t unix_ms, std::uint64_t random_a, std::uint64_t random_b);

/// True for the 8-4-4-4-12 lower-case hexadecimal form.
[[nodiscard]] bool is_uuid(std::string_view text);

/// Whether the bytes are UTF-8 (RFC 3629): shortest forms, no surrogates, nothing beyond U+10FFFF.
[[nodiscard]] bool is_utf8(std::string_view text);

/// Whether UTF-8 text is one line that reads as it is stored: no control characters (C0, DEL, C1), no line or paragraph
/// separator (U+2028, U+2029), no mark that turns the direction of what stands beside it (U+061C, U+200E, U+200F,
/// U+202A to U+202E, U+2066 to U+2069: Unicode Standard Annex #9). False for what is no UTF-8.
[[nodiscard]] bool is_plain_line(std::string_view text);

/// Whether UTF-8 text shows nothing: empty, or only spaces of any kind (Unicode property White_Space), marks of no
/// width (U+200B to U+200D, U+2060, U+FEFF) and blank fillers (U+115F, U+1160, U+2800, U+3164, U+FFA0).
[[nodiscard]] bool is_blank(std::string_view text);

}  // namespace soak::base
