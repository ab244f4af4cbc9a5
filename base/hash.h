// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace soak::base {

using Sha256Digest = std::array<std::uint8_t, 32>;

/// SHA-256 (FIPS 180-4) of a stream of bytes.
class Sha256 {
 public:
  void update(std::span<const std::uint8_t> bytes);
  void update(std::string_view text);
  /// The digest of all that was given. The object must not be used afterwards.
  [[nodiscard]] Sha256Digest finish();

 private:
  void compress(const std::uint8_t* block);

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> pending_{};
  std::size_t pending_size_ = 0;
  std::uint64_t total_size_ = 0;
};

[[nodiscard]] Sha256Digest sha256(std::span<const std::uint8_t> bytes);

/// Lower-case hexadecimal text.
[[nodiscard]] std::string to_hex(std::span<const std::uint8_t> bytes);

/// CRC-32C (Castagnoli: polynomial 0x1EDC6F41 reflected, initial and final value all ones) of `bytes`, RFC 3720 app.
/// B.4. `previous` continues the CRC of the bytes before. Detects every burst of up to 32 bits. Linear in the length.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t previous = 0);

/// The same by tables, for processors without an instruction for it (crc32c() chooses).
[[nodiscard]] std::uint32_t crc32c_by_tables(std::span<const std::uint8_t> bytes, std::uint32_t previous = 0);

}  // namespace soak::base
