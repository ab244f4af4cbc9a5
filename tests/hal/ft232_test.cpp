// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/detail/bulk_stream.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/hal/xsens_peer.h"

namespace soak::hal::usb::test {
namespace {

using imu::test::Bytes;
using imu::test::hex;

// Values that libftdi1 sends.
TEST(Ft232, DivisorsAreThoseOfTheMakersTable) {
  EXPECT_EQ(ft232_divisor(38400)->value, 0xC04E);
  EXPECT_EQ(ft232_divisor(9600)->value, 0x4138);
  EXPECT_EQ(ft232_divisor(115200)->value, 0x001A);
  EXPECT_EQ(ft232_divisor(3'000'000)->value, 0x0000);
  EXPECT_EQ(ft232_divisor(2'000'000)->value, 0x0001);
}

TEST(Ft232, EveryDivisorGivesItsRateWithinThreePercent) {
  constexpr double kEighths[] = {0, 4, 2, 1, 3, 5, 6, 7};  // by the code of AN232B-05
  for (int baud = 184; baud <= 1'400'000; baud += 97) {
    const auto divisor = ft232_divisor(baud);
    ASSERT_TRUE(divisor) << baud;
    const unsigned code = (divisor->value >> 14U) | (divisor->index & 1U) << 2U;
    const double actual = 3e6 / ((divisor->value & 0x3FFFU) + kEighths[code] / 8);
    ASSERT_NEAR(actual, baud, 0.03 * baud);
  }
}

TEST(Ft232, RatesThatTheChipMissesAreRefused) {
  for (const int baud : {-1, 0, 100, 1'700'000, 2'400'000, 4'000'000}) EXPECT_FALSE(ft232_divisor(baud)) << baud;
}

TEST(Ft232, StripsTheStatusOfEachPacketAndNotOfTheTransfer) {
  Bytes bytes;
  append_without_status(hex("01 60 AA BB 01 60 CC"), 4, bytes);
  EXPECT_EQ(bytes, hex("AA BB CC"));
  append_without_status(hex("01 60"), 64, bytes);
  append_without_status(hex("01"), 64, bytes);
  append_without_status({}, 64, bytes);
  EXPECT_EQ(bytes, hex("AA BB CC"));
}

}  // namespace
}  // namespace soak::hal::usb::test
