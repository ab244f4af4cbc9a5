// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace soak::base {

/// Takes one block of 64 bytes into the state of SHA-256 (FIPS 180-4, 6.2.2): by the processor's own instructions where
/// it has them, which takes a fifth of the time.
void compress_sha256(std::array<std::uint32_t, 8>& state, const std::uint8_t* block);

/// The same by arithmetic, for processors without such instructions (compress_sha256() chooses).
void compress_sha256_by_arithmetic(std::array<std::uint32_t, 8>& state, const std::uint8_t* block);

}  // namespace soak::base
