// SPDX-License-Identifier: Apache-2.0
#include "station/records/signing.h"

#include <gtest/gtest.h>

#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

#include "base/hash.h"
#include "calib/deploy/calibration_file.h"

namespace soak::station {
namespace {

base::Bytes from_hex(std::string_view digits) {
  base::Bytes bytes(digits.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::from_chars(digits.data() + 2 * i, digits.data() + 2 * i + 2, bytes[i], 16);
  }
  return bytes;
}

template <class Array>
Array array_of(std::string_view digits) {
  const base::Bytes bytes = from_hex(digits);
  Array array;
  std::copy(bytes.begin(), bytes.end(), array.begin());
  return array;
}

struct Vector {
  std::string_view secret, public_key, message, signature;
};

// RFC 8032 section 7.1: TEST 1, TEST 2, TEST 3, TEST SHA(abc).
constexpr Vector kPublished[] = {
    {"9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60",
     "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a", "",
     "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555fb8821590a33bacc61e39701cf9b46bd25bf5f0595bbe246"
     "5"
     "5141438e7a100b"},
    {"4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb",
     "3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c", "72",
     "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb"
     "0"
     "0d291612bb0c00"},
    {"c5aa8df43f9f837bedb7442f31dcb7b166d38535076f094b85ce3a2e0b4458f7",
     "fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025", "af82",
     "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac18ff9b538d16f290ae67f760984dc6594a7c15e9716ed28dc"
     "0"
     "27beceea1ec40a"},
    {"833fe62409237b9d62ec77587520911e9a759cec1d19755b7da901b96dca3d42",
     "ec172b93ad5e563bf4932c70e1245034c35467ef2efd4d64ebf819683467e2bf",
     "ddaf35a193617abacc417349ae20413112e6fa4e89a97ea20a9eeee64b55d39a2192992a274fc1a836ba3c23a3feebbd454d4423643ce80e2"
     "a"
     "9ac94fa54ca49f",
     "dc2a4459e7369633a52b1bf277839a00201009a3efbf3ecb69bea2186c26b58909351fc9ac90b3ecfdfbc7c66431e0303dca179c138ac17ad"
     "9"
     "bef1177331a704"},
};

SecretKey test_key() { return SecretKey(array_of<SecretKey::Seed>(kPublished[0].secret)); }

base::Bytes golden(const std::string& name) {
  std::ifstream in(SOAK_TEST_FOLDER "/data/golden/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void mend_crc(base::Bytes& file) {
  const std::uint32_t crc = base::crc32c(std::span(file).first(file.size() - 4));
  std::memcpy(file.data() + file.size() - 4, &crc, sizeof crc);
}

TEST(Signing, GivesThePublishedKeysAndSignatures) {
  for (const Vector& vector : kPublished) {
    const SecretKey key(array_of<SecretKey::Seed>(vector.secret));
    const base::Bytes message = from_hex(vector.message);
    EXPECT_EQ(base::to_hex(public_key_of(key)), vector.public_key);
    EXPECT_EQ(base::to_hex(sign(key, message)), vector.signature);
    EXPECT_TRUE(is_signed_by(public_key_of(key), message, array_of<calib::Signature>(vector.signature)));
  }
}

TEST(Signing, AKeyIsCalledByTheBeginningOfItsSha256) {
  const PublicKey key = public_key_of(test_key());
  EXPECT_EQ(base::to_hex(key_id_of(key)), base::to_hex(base::sha256(key)).substr(0, 16));
}

TEST(Signing, RefusesTheSecondSignatureThatTheOrderOfTheGroupAllows) {
  // RFC 8032 section 5.1.7: S + L satisfies the equation too and must be refused, else others could change a file.
  const base::Bytes order = from_hex("edd3f55c1a631258d69cf7a2def9de1400000000000000000000000000000010");
  auto signature = array_of<calib::Signature>(kPublished[0].signature);
  unsigned carry = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    carry += static_cast<unsigned>(signature[32 + i]) + order[i];
    signature[32 + i] = static_cast<std::uint8_t>(carry);
    carry >>= 8;
  }
  ASSERT_EQ(carry, 0U);
  EXPECT_FALSE(is_signed_by(public_key_of(test_key()), {}, signature));
}

TEST(Signing, NewKeysDiffer) {
  const auto one = new_secret_key();
  const auto other = new_secret_key();
  ASSERT_TRUE(one && other);
  EXPECT_NE(one->seed(), other->seed());
}

TEST(Signing, AMovedKeyLeavesNothingBehind) {
  SecretKey key = test_key();
  const SecretKey taken = std::move(key);
  EXPECT_EQ(taken.seed(), test_key().seed());
  EXPECT_EQ(key.seed(), SecretKey::Seed{});  // NOLINT(bugprone-use-after-move): what is tested
}

TEST(SignedFile, IsTheGoldenOne) {
  const auto file = signed_file(golden("fis.soakcal"), test_key());
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(*file, golden("signed.soakcal"));
  EXPECT_TRUE(is_file_signed_by(public_key_of(test_key()), *file));
}

TEST(SignedFile, AFlippedBitIsFoundEvenIfTheCrcIsMended) {
  const base::Bytes good = golden("signed.soakcal");
  const PublicKey key = public_key_of(test_key());
  ASSERT_TRUE(calib::decode(good) && is_file_signed_by(key, good));
  int read = 0;
  // every third bit, so that each of the eight places in a byte has its turn: 0.1 ms each, many more under sanitizers
  for (std::size_t bit = 0; bit < 8 * (good.size() - 4); bit += 3) {
    base::Bytes file = good;
    file[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    mend_crc(file);
    if (!calib::decode(file)) continue;
    ++read;
    ASSERT_FALSE(is_file_signed_by(key, file)) << "bit " << bit;
  }
  EXPECT_GT(read, 1000);  // the signature, not the reader, has found these
}

TEST(SignedFile, AFileWithoutSignatureIsSignedByNobody) {
  EXPECT_FALSE(is_file_signed_by(public_key_of(test_key()), golden("fis.soakcal")));
}

}  // namespace
}  // namespace soak::station
