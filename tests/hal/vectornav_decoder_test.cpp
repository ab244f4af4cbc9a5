// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "base/random.h"
#include "hal/imu/detail/vectornav_frame.h"
#include "tests/hal/vectornav_peer.h"

namespace soak::hal::imu::test {
namespace {

struct Message {
  std::string text;
  VectorNavFields fields;
  Bytes data;

  bool operator==(const Message&) const = default;
};

void drain(VectorNavDecoder& decoder, std::vector<Message>& messages) {
  while (const auto message = decoder.next()) {
    messages.push_back(
        {std::string(message->text), message->fields, Bytes(message->data.begin(), message->data.end())});
  }
}

std::vector<Message> decode(const Bytes& bytes) {
  VectorNavDecoder decoder;
  std::vector<Message> messages;
  decoder.append(bytes);
  drain(decoder, messages);
  return messages;
}

Message said(const std::string& text) { return {text, {}, {}}; }

Bytes difficult_stream() {
  return hex("24 FA FA 05") + golden_vectornav() + text("$VNxx\r\n$$V") + line("VNRRG,03,0100011981") +
         hex("FA 01 FF") + golden_vectornav_ypr() + line("VNWRG,06,0") + hex("FA 05 01 00 10 06 08") +
         golden_vectornav();
}

TEST(VectorNavDecoder, TheCrcIsThatOfXmodem) {
  EXPECT_EQ(vectornav_crc(text("123456789")), 0x31C3);
  base::Random random(1);
  for (int i = 0; i < 200; ++i) {
    Bytes bytes(random.next() % 60);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
    ASSERT_EQ(vectornav_crc(bytes), slow_crc(bytes));
  }
}

TEST(VectorNavDecoder, ReadsTheManualsExample) {
  const auto messages = decode(golden_vectornav_ypr());
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].fields, (VectorNavFields{0x0008, 0}));
  std::array<float, 3> ypr{};
  ASSERT_EQ(messages[0].data.size(), sizeof ypr);
  std::memcpy(ypr.data(), messages[0].data.data(), sizeof ypr);
  EXPECT_FLOAT_EQ(ypr[0], 43.578686F);
  EXPECT_FLOAT_EQ(ypr[1], 1.8847202F);
  EXPECT_FLOAT_EQ(ypr[2], -0.0020249654F);
}

TEST(VectorNavDecoder, ReadsTheWorkedPacket) {
  VectorNavDecoder decoder;
  decoder.append(golden_vectornav());
  const auto message = decoder.next();
  ASSERT_TRUE(message);
  const VectorNavPacket packet = decode_vectornav(*message);
  EXPECT_EQ(packet.time_ns, 0x1CBE991A08U);
  EXPECT_EQ(packet.temp_c, 25.5F);
  EXPECT_EQ(packet.accel_mps2, (std::array<float, 3>{0.1F, -0.2F, -9.81F}));
  EXPECT_EQ(packet.rate_rps, (std::array<float, 3>{0.01F, 0.02F, 0.03F}));
  EXPECT_FALSE(packet.saturation);
}

TEST(VectorNavDecoder, FindsTheFieldsBehindOthersThatItDoesNotUse) {
  const Bytes three = le(1.0F) + le(2.0F) + le(3.0F);
  // Common: time, time of GPS, rate, acceleration; IMU: status, temperature, saturation.
  const Bytes body = Bytes{0x05} + le(std::uint16_t{0x0123}) + le(std::uint16_t{0x0811}) + le(std::uint64_t{7}) +
                     Bytes(8, 9) + three + three + Bytes(2, 0) + le(-3.5F) + le(std::uint16_t{0x40});
  VectorNavDecoder decoder;
  decoder.append(vectornav_frame(body));
  const auto message = decoder.next();
  ASSERT_TRUE(message);
  const VectorNavPacket packet = decode_vectornav(*message);
  EXPECT_EQ(packet.time_ns, 7U);
  EXPECT_EQ(packet.accel_mps2, (std::array<float, 3>{1, 2, 3}));
  EXPECT_EQ(packet.rate_rps, (std::array<float, 3>{1, 2, 3}));
  EXPECT_EQ(packet.temp_c, -3.5F);
  EXPECT_EQ(packet.saturation, 0x40);
}

TEST(VectorNavDecoder, ReadsLinesWithEitherCheck) {
  EXPECT_EQ(decode(line("VNRRG,03,0100011981")), (std::vector<Message>{said("VNRRG,03,0100011981")}));
  std::array<char, 8> check{};
  std::snprintf(check.data(), check.size(), "%04X", slow_crc(text("VNRRG,01,VN-200")));
  EXPECT_EQ(decode(text("$VNRRG,01,VN-200*" + std::string(check.data()) + "\r\n")),
            (std::vector<Message>{said("VNRRG,01,VN-200")}));
  EXPECT_TRUE(decode(text("$VNRRG,01,VN-200*00\r\n")).empty());
  EXPECT_EQ(encode_vectornav("VNRRG,03"), line("VNRRG,03"));
}

TEST(VectorNavDecoder, EverySplitOfTheStreamGivesTheSameMessages) {
  const Bytes stream = difficult_stream();
  const auto expected = decode(stream);
  ASSERT_EQ(expected.size(), 5U);
  for (std::size_t split = 0; split <= stream.size(); ++split) {
    VectorNavDecoder decoder;
    std::vector<Message> messages;
    decoder.append(std::span(stream).first(split));
    drain(decoder, messages);
    decoder.append(std::span(stream).subspan(split));
    drain(decoder, messages);
    ASSERT_EQ(messages, expected) << split;
  }
}

TEST(VectorNavDecoder, EverySingleFlippedBitIsDetectedAndTheNextMessageFound) {
  for (const Bytes& original : {golden_vectornav(), golden_vectornav_ypr(), line("VNRRG,03,0100011981")}) {
    for (std::size_t bit = 0; bit < 8 * original.size(); ++bit) {
      Bytes damaged = original;
      damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
      const bool line_end = original[0] == '$' && bit / 8 >= original.size() - 2;
      if (line_end) continue;  // not covered by the check
      const auto messages = decode(damaged + Bytes(450, 0) + text("\n") + golden_vectornav_ypr());
      ASSERT_EQ(messages.size(), 1U) << bit;
      ASSERT_EQ(messages[0].fields.common, 8) << bit;
    }
  }
}

TEST(VectorNavDecoder, AccountsForEveryRandomByteInBoundedMemory) {
  base::Random random(9);
  VectorNavDecoder decoder;
  std::uint64_t fed = 0;
  std::uint64_t framed = 0;
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes = round % 2 == 0 ? difficult_stream() : Bytes{};
    for (std::uint64_t i = random.next() % 300; i > 0; --i) {
      constexpr std::array<std::uint8_t, 8> kSpecial = {0xFA, '$', 'V', 'N', 0x05, 0x01, '*', '\n'};
      const std::uint64_t word = random.next();
      bytes.push_back(word % 2 == 0 ? kSpecial[(word >> 8U) % kSpecial.size()] : static_cast<std::uint8_t>(word >> 8U));
    }
    decoder.append(bytes);
    fed += bytes.size();
    while (const auto message = decoder.next()) framed += message->frame_size;
    ASSERT_LT(decoder.pending_bytes(), 500U);
    ASSERT_EQ(decoder.garbage_bytes() + framed + decoder.pending_bytes(), fed);
  }
  EXPECT_GT(framed, fed / 10);
}

}  // namespace
}  // namespace soak::hal::imu::test
