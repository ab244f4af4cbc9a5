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

/// Bytes of the sequence at the beginning of the text; 0 where that is none.
std::size_t sequence(std::string_view text) {
  const auto lead = static_cast<std::uint8_t>(text.front());
  for (const Form& form : kForms) {
    if ((lead & form.mask) != form.bits) continue;
    if (text.size() <= form.more) return 0;
    auto point = static_cast<std::uint32_t>(lead & static_cast<std::uint8_t>(~form.mask));
    for (std::size_t i = 1; i <= form.more; ++i) {
      const auto byte = static_cast<std::uint8_t>(text[i]);
      if ((byte & 0xC0U) != 0x80U) return 0;
      point = point << 6U | (byte & 0x3FU);
    }
    const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
    return point < form.least || surrogate || point > 0x10FFFF ? 0 : 1 + form.more;
  }
  return 0;
}

}  // namespace

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = sequence(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

}  // namespace soak::base
