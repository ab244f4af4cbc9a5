// SPDX-License-Identifier: Apache-2.0
// What is refused, and what a later version may add.
#include <gtest/gtest.h>

#include "base/hash.h"
#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using namespace samples;

base::Bytes small_file() { return *encode(with_bias(table(0.01))); }

soak_status load_status(const base::Bytes& bytes) {
  soak_cal cal;
  return soak_load(&cal, bytes.data(), bytes.size());
}

TEST(CalibrationFileDamage, CheckSumIsThePublishedCrc32c) {
  // RFC 3720 B.4 and the check value of the CRC catalogue
  const base::Bytes digits = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  const base::Bytes zeros(32, 0x00);
  EXPECT_EQ(soak_crc32c(digits.data(), digits.size()), 0xE3069283U);
  EXPECT_EQ(soak_crc32c(zeros.data(), zeros.size()), 0x8A9136AAU);
  const base::Bytes bytes = *encode(golden_mixed());
  EXPECT_EQ(get<std::uint32_t>(bytes, bytes.size() - 4), plain_crc32c(bytes.data(), bytes.size() - 4));
}

TEST(CalibrationFileDamage, EverySingleFlippedBitIsRefusedAsCorrupt) {
  for (base::Bytes bytes : {*encode(golden_mixed()), small_file()}) {
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
      bytes[bit / 8] ^= mask;
      const auto read = decode(bytes);
      ASSERT_FALSE(read) << "bit " << bit;
      ASSERT_EQ(read.error().kind, base::ErrorKind::corrupt) << "bit " << bit;
      ASSERT_LT(load_status(bytes), 0) << "bit " << bit;
      bytes[bit / 8] ^= mask;
    }
  }
}

TEST(CalibrationFileDamage, EveryTruncationIsRefused) {
  const base::Bytes whole = *encode(golden_mixed());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const base::Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto read = decode(part);
    ASSERT_FALSE(read) << size;
    // Nothing, and the one byte that a PNG begins with too, may be of any file.
    EXPECT_EQ(read.error().kind, size < 2 ? base::ErrorKind::bad_input : base::ErrorKind::corrupt) << size;
    ASSERT_LT(load_status(part), 0) << size;
  }
}

TEST(CalibrationFileDamage, TrailingBytesAreRefused) {
  base::Bytes bytes = small_file();
  bytes.resize(bytes.size() + 4, 0);
  const auto read = decode(bytes);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, base::ErrorKind::corrupt);
  EXPECT_EQ(read.error().where, "size");
}

TEST(CalibrationFileDamage, AnotherKindOfFileIsBadInput) {
  base::Bytes png = small_file();
  const base::Bytes magic = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  std::copy(magic.begin(), magic.end(), png.begin());
  for (const base::Bytes& bytes : {png, base::Bytes{}, base::Bytes(100, 'a')}) {
    const auto read = decode(bytes);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(read.error().where, "magic");
  }
}

TEST(CalibrationFileDamage, TransferAsTextIsNamed) {
  base::Bytes unix_ends;
  const base::Bytes whole = small_file();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole[i] == '\r' && i + 1 < whole.size() && whole[i + 1] == '\n') continue;
    unix_ends.push_back(whole[i]);
  }
  const auto read = decode(unix_ends);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, base::ErrorKind::corrupt);
  EXPECT_EQ(read.error().where, "magic");
}

TEST(CalibrationFileVersions, NewerMinorVersionWithALongerHeaderIsRead) {
  base::Bytes bytes = small_file();
  put<std::uint16_t>(bytes, 10, 9);
  put<std::uint32_t>(bytes, 16, 32);
  bytes.insert(bytes.begin() + 24, 8, 0xAB);
  seal(bytes);
  const auto read = decode(bytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->unit, "SN-0003");
  EXPECT_EQ(load_status(bytes), SOAK_OK);
}

TEST(CalibrationFileVersions, NewerMajorVersionIsRefusedByName) {
  base::Bytes bytes = small_file();
  put<std::uint16_t>(bytes, 8, 2);
  seal(bytes);
  const auto read = decode(bytes);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(read.error().where, "version");
  EXPECT_EQ(load_status(bytes), SOAK_E_VERSION);
}

TEST(CalibrationFileVersions, UnknownIgnorableSectionIsSkipped) {
  for (const std::uint16_t type : {std::uint16_t{0x0040}, std::uint16_t{0x0777}, std::uint16_t{0x8001}}) {
    base::Bytes bytes = small_file();
    append_section(bytes, type, 1, false, {1, 2, 3, 4});
    const auto read = decode(bytes);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_DOUBLE_EQ(evaluate(read->sensors[0].bias, 1.0), evaluate(decode(small_file())->sensors[0].bias, 1.0));
    EXPECT_EQ(load_status(bytes), SOAK_OK);
  }
}

TEST(CalibrationFileVersions, UnknownCriticalSectionRefusesTheFile) {
  base::Bytes bytes = small_file();
  append_section(bytes, 0x0777, 1, true, {});
  const auto read = decode(bytes);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(load_status(bytes), SOAK_E_UNKNOWN);
}

TEST(CalibrationFileVersions, UnknownVersionOfAKnownSectionCountsAsUnknown) {
  base::Bytes ignorable = small_file();
  append_section(ignorable, SOAK_SECTION_UNCERTAINTY, 2, false, {});
  EXPECT_TRUE(decode(ignorable));
  base::Bytes critical = small_file();
  append_section(critical, SOAK_SECTION_MISALIGNMENT, 2, true, {});
  EXPECT_EQ(load_status(critical), SOAK_E_UNKNOWN);
}

TEST(CalibrationFileFormat, WhatBreaksARuleUnderAGoodCheckSumIsCorrupt) {
  const base::Bytes zeros(36, 0);
  base::Bytes twice = *encode(golden_mixed());
  append_section(twice, SOAK_SECTION_MISALIGNMENT, 1, true, zeros);
  base::Bytes type_zero = small_file();
  append_section(type_zero, 0, 1, false, {});
  base::Bytes foreign_sensor = small_file();  // a curve of a sensor that is not in the file
  append_section(foreign_sensor, SOAK_SECTION_TABLE, 1, true, {5, 0, 1, 0});
  base::Bytes bare_sensor = small_file();  // a sensor without bias curve
  append_section(bare_sensor, SOAK_SECTION_SENSOR, 1, true, {5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  base::Bytes miscounted = small_file();
  put<std::uint32_t>(miscounted, 20, get<std::uint32_t>(miscounted, 20) - 1);
  seal(miscounted);
  base::Bytes odd_length = small_file();
  append_section(odd_length, 0x8000, 1, false, {1, 2, 3});
  base::Bytes broken_term = small_file();
  append_section(broken_term, SOAK_SECTION_TERM, 1, false, {0, 0, 200, 0});
  base::Bytes many_terms = small_file();
  for (int i = 0; i < 33; ++i) {
    append_section(many_terms, SOAK_SECTION_TERM, 1, false, {0, 0, 1, 0, 'a', 0, 0, 0});
  }
  for (const base::Bytes& bytes :
       {twice, type_zero, foreign_sensor, bare_sensor, miscounted, odd_length, broken_term, many_terms}) {
    const auto read = decode(bytes);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().kind, base::ErrorKind::corrupt);
  }
}

TEST(CalibrationFileFormat, ValuesThatAnEnumeratedFieldDoesNotListAreRefused) {
  const base::Bytes good = *encode(with_bias(fis(0, anfis::Shape::bell, 0.0, 1.0)));
  const std::size_t curve = payload_of(good, SOAK_SECTION_FIS, 0, 0);
  const std::size_t sensor = payload_of(good, SOAK_SECTION_SENSOR, 0, 5);  // name "anfis": 5 bytes
  ASSERT_GT(curve, 0U);
  ASSERT_GT(sensor, 0U);
  // sensor, quantity, membership, order; order 0 with the slopes of order 1; sensor of the sensor's own section
  for (const auto& [at, value] :
       {std::pair{curve, 6}, {curve + 1, 2}, {curve + 2, 2}, {curve + 3, 2}, {curve + 3, 0}, {sensor, 6}}) {
    base::Bytes bytes = good;
    bytes[at] = static_cast<std::uint8_t>(value);
    seal(bytes);
    EXPECT_EQ(load_status(bytes), SOAK_E_FORMAT) << at << ' ' << value;
  }
}

TEST(CalibrationFileFormat, UnusedBitsAndUnnamedSensorsOfATermAreIgnored) {
  base::Bytes bytes = small_file();
  append_section(bytes, SOAK_SECTION_TERM, 1, false, {0xFE, 0xE0, 1, 0, 'a', 0, 0, 0});  // accel_z is not in the file
  const auto read = decode(bytes);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->terms.size(), 1U);
  EXPECT_FALSE(read->terms[0].lab_only);
  EXPECT_EQ(read->terms[0].sensors, std::vector<Sensor>{Sensor::accel_z});
}

}  // namespace
}  // namespace soak::calib
