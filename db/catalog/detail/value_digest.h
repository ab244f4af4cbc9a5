// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/hash.h"

/// Values of SQLite as digests of the catalog take them (docs/file-formats.md): each with its type, so that 1, 1.0, '1'
/// and NULL differ, and a text with its length.
namespace soak::db::catalog {

inline void add_number(base::Sha256& hash, char type, std::uint64_t bits) {
  std::array<std::uint8_t, 9> bytes{static_cast<std::uint8_t>(type)};
  for (std::size_t i = 0; i < 8; ++i) bytes[i + 1] = static_cast<std::uint8_t>(bits >> (8 * i));
  hash.update(bytes);
}

inline void add_null(base::Sha256& hash) { add_number(hash, 'n', 0); }
inline void add_integer(base::Sha256& hash, std::int64_t value) {
  add_number(hash, 'i', static_cast<std::uint64_t>(value));
}
inline void add_real(base::Sha256& hash, double value) { add_number(hash, 'f', std::bit_cast<std::uint64_t>(value)); }
inline void add_text(base::Sha256& hash, std::string_view text) {
  add_number(hash, 't', text.size());
  hash.update(text);
}

}  // namespace soak::db::catalog
