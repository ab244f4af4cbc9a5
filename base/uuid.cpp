// SPDX-License-Identifier: Apache-2.0
#include "base/uuid.h"

#include <fmt/format.h>

#include <cstddef>

namespace soak::base {

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
    const bool hex = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
    if (dash ? c != '-' : !hex) return false;
  }
  return true;
}

}  // namespace soak::base
