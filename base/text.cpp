// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace soak::base {
namespace {

template <class T>
std::optional<T> parse(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-') || text.starts_with('+')) return std::nullopt;
  }
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

template <class T>
std::string to_shortest(T value) {
  std::array<char, 64> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return error == std::errc{} ? std::string(buffer.data(), end) : std::string();
}

/// How a sequence begins: `bits` under `mask`, then `more` bytes, for code points from `least`.
struct Form {
  std::uint8_t mask;
  std::uint8_t bits;
  std::size_t more;
  std::uint32_t least;
};

constexpr std::array<Form, 4> kForms = {
    {{0x80, 0x00, 0, 0x0}, {0xE0, 0xC0, 1, 0x80}, {0xF0, 0xE0, 2, 0x800}, {0xF8, 0xF0, 3, 0x10000}}};

/// The code point at the beginning of a text, and its bytes; 0 bytes where there is none.
struct Sequence {
  std::size_t length = 0;
  std::uint32_t point = 0;
};
Sequence sequence(std::string_view text) {
  const auto lead = static_cast<std::uint8_t>(text.front());
  for (const Form& form : kForms) {
    if ((lead & form.mask) != form.bits) continue;
    if (text.size() <= form.more) return {};
    auto point = static_cast<std::uint32_t>(lead & static_cast<std::uint8_t>(~form.mask));
    for (std::size_t i = 1; i <= form.more; ++i) {
      const auto byte = static_cast<std::uint8_t>(text[i]);
      if ((byte & 0xC0U) != 0x80U) return {};
      point = point << 6U | (byte & 0x3FU);
    }
    const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
    if (point < form.least || surrogate || point > 0x10FFFF) return {};
    return {1 + form.more, point};
  }
  return {};
}

constexpr bool is_control(std::uint32_t point) { return point < 0x20 || (point >= 0x7F && point <= 0x9F); }
constexpr bool ends_a_line(std::uint32_t point) { return point == 0x2028 || point == 0x2029; }
constexpr bool turns_direction(std::uint32_t point) {
  return point == 0x061C || point == 0x200E || point == 0x200F || (point >= 0x202A && point <= 0x202E) ||
         (point >= 0x2066 && point <= 0x2069);
}

/// Whether the text is UTF-8 of code points that `allowed` takes.
template <class Allowed>
bool all_points(std::string_view text, Allowed allowed) {
  while (!text.empty()) {
    const auto [length, point] = sequence(text);
    if (length == 0 || !allowed(point)) return false;
    text.remove_prefix(length);
  }
  return true;
}

}  // namespace

std::optional<double> parse_double(std::string_view text) {
  const auto value = parse<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<float> parse_float(std::string_view text) {
  const auto value = parse<float>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> parse_int(std::string_view text) { return parse<std::int64_t>(text); }

std::string shortest(double value) { return to_shortest(value); }
std::string shortest(float value) { return to_shortest(value); }

std::string utc_text(double unix_s) {
  constexpr double kEndOfYear9999_s = 253402300800.0;
  if (!(unix_s >= 0.0) || unix_s >= kEndOfYear9999_s) return shortest(unix_s);
  const std::chrono::sys_seconds time{std::chrono::seconds(static_cast<std::int64_t>(unix_s))};
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  return fmt::format("{}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), clock.hours().count(),
                     clock.minutes().count(), clock.seconds().count());
}

std::string uuid_v7(std::uint64_t unix_ms, std::uint64_t random_a, std::uint64_t random_b) {
  const std::uint64_t time48 = unix_ms & 0xFFFFFFFFFFFF;
  const std::uint64_t version_and_a = 0x7000 | (random_a & 0x0FFF);
  const std::uint64_t variant_and_b = 0x8000000000000000 | (random_b & 0x3FFFFFFFFFFFFFFF);
  return fmt::format("{:08x}-{:04x}-{:04x}-{:04x}-{:012x}", time48 >> 16, time48 & 0xFFFF, version_and_a,
                     variant_and_b >> 48, variant_and_b & 0xFFFFFFFFFFFF);
}

bool is_uuid(std::string_view text) {
  if (text.size() != 36) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
    const bool hex = hex_digit(c) >= 0;
    if (dash ? c != '-' : !hex) return false;
  }
  return true;
}

bool is_utf8(std::string_view text) {
  return all_points(text, [](std::uint32_t) { return true; });
}

bool is_plain_line(std::string_view text) {
  return all_points(
      text, [](std::uint32_t point) { return !is_control(point) && !ends_a_line(point) && !turns_direction(point); });
}

bool is_blank(std::string_view text) {
  return all_points(text, [](std::uint32_t c) {
    return (c >= 0x09 && c <= 0x0D) || c == 0x20 || c == 0x85 || c == 0xA0 || c == 0x115F || c == 0x1160 ||
           c == 0x1680 || (c >= 0x2000 && c <= 0x200D) || c == 0x2028 || c == 0x2029 || c == 0x202F || c == 0x205F ||
           c == 0x2060 || c == 0x2800 || c == 0x3000 || c == 0x3164 || c == 0xFEFF || c == 0xFFA0;
  });
}

}  // namespace soak::base
