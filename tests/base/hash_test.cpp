// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/hash.h"
#include "base/sha256_block.h"
#include "base/text.h"

namespace soak::base {
namespace {

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(Crc32c, MatchesTheVectorsOfRfc3720) {
  // RFC 3720 B.4: 32 bytes of zeros, of ones, rising, falling.
  std::vector<std::uint8_t> bytes(32, 0);
  EXPECT_EQ(crc32c(bytes), 0x8a9136aaU);
  bytes.assign(32, 0xff);
  EXPECT_EQ(crc32c(bytes), 0x62a8ab43U);
  for (std::size_t i = 0; i < 32; ++i) bytes[i] = static_cast<std::uint8_t>(i);
  EXPECT_EQ(crc32c(bytes), 0x46dd794eU);
  for (std::size_t i = 0; i < 32; ++i) bytes[i] = static_cast<std::uint8_t>(31 - i);
  EXPECT_EQ(crc32c(bytes), 0x113fdb5cU);
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xe3069283U);
}

TEST(Crc32c, ContinuesWhereAnEarlierPartEnded) {
  const std::string text = "a longer text that is cut somewhere in its middle";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    EXPECT_EQ(crc32c(bytes_of(text).subspan(cut), crc32c(bytes_of(text).first(cut))), crc32c(bytes_of(text)));
  }
}

/// The remainder bit by bit, as RFC 3720 defines it.
std::uint32_t crc32c_by_bits(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0x82F63B78U : 0U);
  }
  return ~crc;
}

TEST(Crc32c, IsTheSameWithAndWithoutTheInstructionAtEveryLengthAndAlignment) {
  std::vector<std::uint8_t> bytes(100);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i + 7);
  for (std::size_t first = 0; first < 9; ++first) {
    for (std::size_t count = 0; first + count <= bytes.size(); ++count) {
      const auto part = std::span(bytes).subspan(first, count);
      EXPECT_EQ(crc32c(part), crc32c_by_bits(part));
      EXPECT_EQ(crc32c_by_tables(part), crc32c_by_bits(part));
    }
  }
}

TEST(Sha256, MatchesTheExamplesOfFips180) {
  EXPECT_EQ(to_hex(sha256(bytes_of(""))), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(to_hex(sha256(bytes_of("abc"))), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(to_hex(sha256(bytes_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"))),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, DoesNotDependOnHowTheInputIsCut) {
  const std::string million(1000000, 'a');
  Sha256 hash;
  for (std::size_t i = 0; i < million.size(); i += 997) hash.update(std::string_view(million).substr(i, 997));
  EXPECT_EQ(to_hex(hash.finish()), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, IsTheSameByArithmeticAsByInstructions) {
  std::array<std::uint32_t, 8> chosen{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint32_t, 8> by_arithmetic = chosen;
  std::array<std::uint8_t, 65> bytes{};
  std::uint32_t state = 1;
  for (int block = 0; block < 2000; ++block) {
    for (std::uint8_t& byte : bytes) {
      state = state * 1664525U + 1013904223U;
      byte = static_cast<std::uint8_t>(state >> 24U);
    }
    compress_sha256(chosen, bytes.data() + block % 2);  // also where no word of it is aligned
    compress_sha256_by_arithmetic(by_arithmetic, bytes.data() + block % 2);
    ASSERT_EQ(chosen, by_arithmetic) << block;
  }
}

TEST(UuidV7, HasTheLayoutOfRfc9562) {
  // RFC 9562 A.6: 2022-02-22 19:22:22 UTC, rand_a = CC3, rand_b = 18C4DC0C0C07398F.
  EXPECT_EQ(uuid_v7(0x017F22E279B0, 0xCC3, 0x18C4DC0C0C07398F), "017f22e2-79b0-7cc3-98c4-dc0c0c07398f");
  EXPECT_TRUE(is_uuid(uuid_v7(~0ULL, ~0ULL, ~0ULL)));
  EXPECT_FALSE(is_uuid("017f22e2-79b0-7cc3-98c4-dc0c0c07398"));
  EXPECT_FALSE(is_uuid("017F22e2-79b0-7cc3-98c4-dc0c0c07398f"));
}

TEST(UuidV7, SortsByTime) { EXPECT_LT(uuid_v7(1000, 0xFFF, ~0ULL), uuid_v7(1001, 0, 0)); }

}  // namespace
}  // namespace soak::base
