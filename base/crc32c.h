// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace soak::base {

/// CRC-32C (Castagnoli: polynomial 0x1EDC6F41 reflected, initial and final value all ones) of `bytes`, RFC 3720 app.
/// B.4. `previous` continues the CRC of the bytes before. Detects every burst of up to 32 bits. Linear in the length.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t previous = 0);

/// The same by tables, for processors without an instruction for it (crc32c() chooses).
[[nodiscard]] std::uint32_t crc32c_by_tables(std::span<const std::uint8_t> bytes, std::uint32_t previous = 0);

}  // namespace soak::base
