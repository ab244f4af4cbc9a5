// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/electronics/detail/xbus_device.h"

#include <gtest/gtest.h>

#include <bit>

#include <numeric>
#include <vector>

namespace soak::hal::sim {
namespace {

using base::Bytes;

// Frames of real exchanges, published with public drivers and captures of the maker's own program.
const Bytes kGotoConfig = {0xFA, 0xFF, 0x30, 0x00, 0xD1};
const Bytes kGotoMeasurement = {0xFA, 0xFF, 0x10, 0x00, 0xF1};
const Bytes kCaptured = {0xFA, 0xFF, 0x36, 0x26, 0x10, 0x20, 0x02, 0x46, 0x82, 0x10, 0x60, 0x04, 0x01, 0xC4, 0xFC,
                         0x3E, 0x20, 0x10, 0x10, 0x3F, 0x71, 0xCE, 0x6C, 0xBE, 0xA5, 0x6B, 0xCF, 0x3C, 0x61, 0x3B,
                         0xD8, 0xBD, 0x69, 0x1D, 0x25, 0xE0, 0x20, 0x04, 0x00, 0x40, 0x00, 0x03, 0x12};

TEST(XbusFrame, IsThatOfPublishedExchanges) {
  EXPECT_EQ(xbus_frame(0x30, {}), kGotoConfig);
  EXPECT_EQ(xbus_frame(0x10, {}), kGotoMeasurement);
  EXPECT_EQ(xbus_frame(0x36, std::span(kCaptured).subspan(4, 0x26)), kCaptured);
}

TEST(XbusFrame, HasAnExtendedLengthBeyond254Bytes) {
  const Bytes longest_short(254, 1);
  EXPECT_EQ(xbus_frame(0x36, longest_short)[3], 254);
  const Bytes data(255, 1);
  const Bytes frame = xbus_frame(0x36, data);
  EXPECT_EQ(Bytes(frame.begin(), frame.begin() + 6), (Bytes{0xFA, 0xFF, 0x36, 0xFF, 0x00, 0xFF}));
  EXPECT_EQ(frame.size(), 6U + 255U + 1U);
  EXPECT_EQ(std::accumulate(frame.begin() + 1, frame.end(), 0U) % 256U, 0U);
}

TEST(XbusFrame, CarriesNumbersBigEndian) {
  Bytes bytes;
  base::append_big_endian(bytes, std::uint16_t{0x1234});
  base::append_big_endian(bytes, std::uint32_t{0x89ABCDEF});
  base::append_big_endian(bytes, std::bit_cast<std::uint32_t>(37.625F));  // 42 16 80 00 in the capture of an MTi-300
  EXPECT_EQ(bytes, (Bytes{0x12, 0x34, 0x89, 0xAB, 0xCD, 0xEF, 0x42, 0x16, 0x80, 0x00}));
}

TEST(XbusParser, FindsMessagesThatComeByteByByte) {
  XbusParser parser;
  for (std::size_t i = 0; i < kCaptured.size(); ++i) {
    ASSERT_FALSE(parser.next());
    parser.feed(std::span(kCaptured).subspan(i, 1));
  }
  const auto message = parser.next();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->id, 0x36);
  EXPECT_EQ(message->data, Bytes(kCaptured.begin() + 4, kCaptured.end() - 1));
  EXPECT_FALSE(parser.next());
}

TEST(XbusParser, FindsTheMessageThatABrokenOneHides) {
  Bytes bytes = {0x00, 0xFA, 0xFF, 0x30, 0x07};  // claims seven bytes: the next frame and two more
  bytes.insert(bytes.end(), kGotoConfig.begin(), kGotoConfig.end());
  bytes.insert(bytes.end(), {0x00, 0x00, 0x55});
  bytes.insert(bytes.end(), kGotoMeasurement.begin(), kGotoMeasurement.end());
  XbusParser parser;
  parser.feed(bytes);
  const auto first = parser.next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->id, 0x30);
  const auto second = parser.next();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->id, 0x10);
  EXPECT_FALSE(parser.next());
}

TEST(XbusParser, GivesNoMessageWithAWrongChecksum) {
  for (std::size_t i = 1; i < kGotoConfig.size(); ++i) {
    Bytes broken = kGotoConfig;
    broken[i] ^= 0x01;
    broken.resize(64, 0);  // enough for any length that the broken byte may claim
    XbusParser parser;
    parser.feed(broken);
    EXPECT_FALSE(parser.next()) << i;
  }
}

TEST(XbusParser, DoesNotWaitForMoreDataThanAMessageCanHave) {
  Bytes bytes = {0xFA, 0xFF, 0x36, 0xFF, 0xFF, 0xFF};
  bytes.insert(bytes.end(), kGotoConfig.begin(), kGotoConfig.end());
  XbusParser parser;
  parser.feed(bytes);
  const auto message = parser.next();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->id, 0x30);
}

}  // namespace
}  // namespace soak::hal::sim
