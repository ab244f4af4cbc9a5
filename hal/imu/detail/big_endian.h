// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

namespace soak::hal::imu {

/// The number whose most significant byte stands first at `bytes`; the caller has checked that all are there.
template <std::unsigned_integral T>
[[nodiscard]] T big_endian(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8U | bytes[i];
  return static_cast<T>(value);
}

}  // namespace soak::hal::imu
