// SPDX-License-Identifier: Apache-2.0
#include "base/utf8.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace soak::base {
namespace {

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

bool is_utf8(std::string_view text) {
  return all_points(text, [](std::uint32_t) { return true; });
}

bool is_plain_line(std::string_view text) {
  return all_points(
      text, [](std::uint32_t point) { return !is_control(point) && !ends_a_line(point) && !turns_direction(point); });
}

}  // namespace soak::base
