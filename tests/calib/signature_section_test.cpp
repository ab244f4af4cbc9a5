// SPDX-License-Identifier: Apache-2.0
// Files of format version 1.1: with a signature section, which readers of version 1.0 pass over.
#include "calib/deploy/signature.h"

#include <gtest/gtest.h>

#include <string>

#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using namespace samples;

constexpr KeyId kKey = {1, 2, 3, 4, 5, 6, 7, 8};

Signature counting_signature() {
  Signature signature;
  for (std::size_t i = 0; i < signature.size(); ++i) signature[i] = static_cast<std::uint8_t>(i + 100);
  return signature;
}

base::Bytes with_signature(const base::Bytes& file, const KeyId& key = kKey) {
  base::Bytes signed_bytes = *with_empty_signature(file, key);
  put_signature(signed_bytes, counting_signature());
  return signed_bytes;
}

base::Bytes unsigned_file() { return read_file(data_file("fis.soakcal")); }

TEST(SignatureSection, StandsWhereTheFormatSaysAndNothingElseChanges) {
  const base::Bytes before = unsigned_file();
  const base::Bytes after = with_signature(before);
  // docs/blob-format.md: minor version 1, size, count; the old sections; head, key number, signature, CRC
  ASSERT_EQ(after.size(), before.size() + 80);
  base::Bytes expected(before.begin(), before.end() - 4);
  put(expected, 10, std::uint16_t{1});
  put(expected, 12, static_cast<std::uint32_t>(after.size()));
  put(expected, 20, get<std::uint32_t>(before, 20) + 1);
  for (const int byte : {0x40, 0, 1, 0, 72, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8}) {
    expected.push_back(static_cast<std::uint8_t>(byte));
  }
  const std::string prefix = "soak-signature-1";
  base::Bytes message(prefix.begin(), prefix.end());
  message.insert(message.end(), expected.begin(), expected.end());
  EXPECT_EQ(signed_message(after), message);
  const Signature signature = counting_signature();
  expected.insert(expected.end(), signature.begin(), signature.end());
  expected.resize(after.size());
  put(expected, after.size() - 4, plain_crc32c(expected.data(), expected.size() - 4));
  EXPECT_EQ(after, expected);
}

TEST(SignatureSection, ReadersThatDoNotKnowItGiveTheSameValues) {
  const base::Bytes before = unsigned_file();
  const base::Bytes after = read_file(data_file("signed.soakcal"));
  soak_cal old_cal;
  soak_cal new_cal;
  ASSERT_EQ(soak_load(&old_cal, before.data(), before.size()), SOAK_OK);
  ASSERT_EQ(soak_load(&new_cal, after.data(), after.size()), SOAK_OK);
  const float raw[6] = {0.5F, -0.25F, 0.125F, 1.5F, -2.25F, 9.75F};
  for (float temp_c = -35.0F; temp_c < 80.0F; temp_c += 2.5F) {
    float expected[6];
    float out[6];
    std::uint32_t expected_flags = 0;
    std::uint32_t flags = 0;
    EXPECT_EQ(soak_apply(&new_cal, temp_c, raw, out, &flags),
              soak_apply(&old_cal, temp_c, raw, expected, &expected_flags));
    EXPECT_EQ(flags, expected_flags);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(out[i], expected[i]);
  }
  const auto calibration = decode(after);
  ASSERT_TRUE(calibration) << calibration.error().message;
  EXPECT_EQ(*encode(*calibration), *encode(*decode(before)));
}

TEST(SignatureSection, IsFoundAgainAndReplaced) {
  const base::Bytes once = with_signature(unsigned_file());
  const auto section = signature_of(once);
  ASSERT_TRUE(section);
  EXPECT_EQ(section->key_id, kKey);
  EXPECT_EQ(section->signature, counting_signature());
  constexpr KeyId other = {9, 9};
  const base::Bytes twice = with_signature(once, other);
  EXPECT_EQ(signature_of(twice)->key_id, other);
  EXPECT_EQ(with_signature(twice), once);
}

TEST(SignatureSection, OneThatIsNotTheLastIsNoSignatureAndIsReplacedToo) {
  base::Bytes file = with_signature(unsigned_file());
  append_section(file, 0x8000, 1, false, {1, 2, 3, 4});
  ASSERT_TRUE(decode(file));
  EXPECT_FALSE(signature_of(file));
  const base::Bytes signed_again = with_signature(file);
  EXPECT_TRUE(signature_of(signed_again));
  EXPECT_EQ(signed_again.size(), file.size());
  base::Bytes expected = unsigned_file();
  append_section(expected, 0x8000, 1, false, {1, 2, 3, 4});
  EXPECT_EQ(signed_again, with_signature(expected));
}

TEST(SignatureSection, AnotherVersionOrLengthIsNoSignature) {
  const base::Bytes plain = unsigned_file();
  EXPECT_FALSE(signature_of(plain));
  base::Bytes longer = plain;
  append_section(longer, 0x0040, 1, false, base::Bytes(76));
  EXPECT_FALSE(signature_of(longer));
  base::Bytes later = plain;
  append_section(later, 0x0040, 2, false, base::Bytes(72));
  EXPECT_FALSE(signature_of(later));
}

TEST(SignatureSection, NeedsRoomInTheFile) {
  base::Bytes file = unsigned_file();
  while (get<std::uint32_t>(file, 20) < SOAK_MAX_SECTIONS) append_section(file, 0x8000, 1, false, {});
  const auto refused = with_empty_signature(file, kKey);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  base::Bytes large = unsigned_file();
  append_section(large, 0x8000, 1, false, base::Bytes(SOAK_MAX_FILE - 8 - 76 - large.size()));
  ASSERT_TRUE(decode(large));
  EXPECT_FALSE(with_empty_signature(large, kKey));  // 4 bytes too long
  base::Bytes fits = unsigned_file();
  append_section(fits, 0x8000, 1, false, base::Bytes(SOAK_MAX_FILE - 8 - 80 - fits.size()));
  EXPECT_TRUE(with_empty_signature(fits, kKey));
}

TEST(MinorVersion, IsTheLeastThatHasAllSectionsOfTheFile) {
  TableCurve curve = table(0.1);
  EXPECT_EQ(get<std::uint16_t>(*encode(with_bias(curve)), 10), 0);
  curve.bound = 1e-6;
  EXPECT_EQ(get<std::uint16_t>(*encode(with_bias(curve)), 10), 1);
}

TEST(MinorVersion, OfALaterWriterIsKeptWhenTheFileIsSigned) {
  base::Bytes file = unsigned_file();
  put(file, 10, std::uint16_t{7});
  seal(file);
  EXPECT_EQ(get<std::uint16_t>(with_signature(file), 10), 7);
}

}  // namespace
}  // namespace soak::calib
