// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace soak::base {

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

}  // namespace soak::base
