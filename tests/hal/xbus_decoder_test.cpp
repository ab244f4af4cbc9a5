// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/hal/decoder_wires.h"

namespace soak::hal::imu::test {
namespace {

using XbusMessage = XbusWire::Message;

std::vector<XbusMessage> decoded_xbus(const Bytes& bytes) { return test::decode<XbusWire>(bytes); }

Bytes data_of(const Bytes& whole) { return Bytes(whole.begin() + 4, whole.end() - 1); }

const Bytes kLong = Bytes(300, 0x11);

TEST(XbusDecoder, ReadsTheGoldenFrames) {
  const auto messages = decoded_xbus(golden_with_temperature() + golden_short());
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0], (XbusMessage{0xFF, 0x36, data_of(golden_with_temperature())}));
  EXPECT_EQ(messages[1], (XbusMessage{0xFF, 0x36, data_of(golden_short())}));
}

TEST(XbusDecoder, ReadsAnExtendedLength) {
  const auto messages = decoded_xbus(frame(0x36, kLong));
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].data, kLong);
}

TEST(XbusDecoder, ReadsTheLongestMessageAndRefusesALongerOne) {
  EXPECT_EQ(decoded_xbus(frame(0x36, Bytes(8185, 1))).size(), 1U);
  EXPECT_TRUE(decoded_xbus(frame(0x36, Bytes(8186, 1))).empty());
}

TEST(XbusDecoder, CountsEveryByteThatBelongsToNoFrame) {
  XbusDecoder decoder;
  std::vector<XbusMessage> messages;
  decoder.append(hex("01 02 03") + frame(0x31) + hex("FA FF 31 00 D1") + frame(0x11));  // the second has a wrong sum
  drain<XbusWire>(decoder, messages);
  EXPECT_EQ(messages, (std::vector<XbusMessage>{{0xFF, 0x31, {}}, {0xFF, 0x11, {}}}));
  EXPECT_EQ(decoder.garbage_bytes(), 3U + 5U);
}

TEST(XbusDecoder, FindsAFrameThatBeginsInsideAFalseOne) {
  const auto messages = decoded_xbus(hex("FA FF 36 20") + frame(0x31) + Bytes(40, 0));
  EXPECT_EQ(messages, (std::vector<XbusMessage>{{0xFF, 0x31, {}}}));
}

TEST(XbusDecoder, ZerosBehindAnFaAreNoMessageAlthoughTheirSumHolds) {
  EXPECT_TRUE(decoded_xbus(hex("FA 00 00 00 00")).empty());
}

TEST(XbusDecoder, GivesUpAFrameThatDoesNotEnd) {
  XbusDecoder decoder;
  std::vector<XbusMessage> messages;
  decoder.append(hex("FA FF 36 FF 1F F0") + frame(0x31));
  drain<XbusWire>(decoder, messages);
  EXPECT_TRUE(messages.empty());
  while (decoder.drop_partial()) drain<XbusWire>(decoder, messages);
  EXPECT_EQ(messages, (std::vector<XbusMessage>{{0xFF, 0x31, {}}}));
  EXPECT_EQ(decoder.garbage_bytes(), 6U);
}

// Flipping bit k of a byte changes the sum by 2^k or -2^k, never by a multiple of 256: a frame of the same extent
// cannot pass. A flipped bit in the length gives another extent, whose sum holds by chance once in 256; in these frames
// it happens nowhere. What follows is found again in every case.
TEST(XbusDecoder, EverySingleFlippedBitIsDetected) {
  for (const Bytes& original : {golden_with_temperature(), golden_short()}) {
    for (std::size_t bit = 0; bit < 8 * original.size(); ++bit) {
      Bytes damaged = original;
      damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
      const auto messages = decoded_xbus(damaged + Bytes(300, 0) + frame(0x31));
      ASSERT_EQ(messages, (std::vector<XbusMessage>{{0xFF, 0x31, {}}})) << "bit " << bit;
    }
  }
}

TEST(XbusDecoder, EncodesTheQuotedCommands) {
  EXPECT_EQ(encode_xbus(Mid::go_to_config), hex("FA FF 30 00 D1"));
  EXPECT_EQ(encode_xbus(Mid::go_to_measurement), hex("FA FF 10 00 F1"));
  EXPECT_EQ(
      encode_xbus(Mid::set_output_configuration, hex("10 20 FF FF 10 60 FF FF 40 20 00 64 80 20 00 64 08 10 00 0A")),
      hex("FA FF C0 14 10 20 FF FF 10 60 FF FF 40 20 00 64 80 20 00 64 08 10 00 0A A7"));
  EXPECT_EQ(encode_xbus(Mid::mt_data2, kLong), frame(0x36, kLong));
}

}  // namespace
}  // namespace soak::hal::imu::test
