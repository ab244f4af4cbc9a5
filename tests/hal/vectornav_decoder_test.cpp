// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "base/random.h"
#include "tests/hal/decoder_wires.h"

namespace soak::hal::imu::test {
namespace {

using VectorNavMessage = VectorNavWire::Message;

std::vector<VectorNavMessage> decoded_vectornav(const Bytes& bytes) { return test::decode<VectorNavWire>(bytes); }

VectorNavMessage said(const std::string& text) { return {text, {}, {}}; }

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
  const auto messages = decoded_vectornav(golden_vectornav_ypr());
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
  EXPECT_EQ(decoded_vectornav(line("VNRRG,03,0100011981")),
            (std::vector<VectorNavMessage>{said("VNRRG,03,0100011981")}));
  std::array<char, 8> check{};
  std::snprintf(check.data(), check.size(), "%04X", slow_crc(text("VNRRG,01,VN-200")));
  EXPECT_EQ(decoded_vectornav(text("$VNRRG,01,VN-200*" + std::string(check.data()) + "\r\n")),
            (std::vector<VectorNavMessage>{said("VNRRG,01,VN-200")}));
  EXPECT_TRUE(decoded_vectornav(text("$VNRRG,01,VN-200*00\r\n")).empty());
  EXPECT_EQ(encode_vectornav("VNRRG,03"), line("VNRRG,03"));
}

TEST(VectorNavDecoder, EverySingleFlippedBitIsDetectedAndTheNextMessageFound) {
  for (const Bytes& original : {golden_vectornav(), golden_vectornav_ypr(), line("VNRRG,03,0100011981")}) {
    for (std::size_t bit = 0; bit < 8 * original.size(); ++bit) {
      Bytes damaged = original;
      damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
      const bool line_end = original[0] == '$' && bit / 8 >= original.size() - 2;
      if (line_end) continue;  // not covered by the check
      const auto messages = decoded_vectornav(damaged + Bytes(450, 0) + text("\n") + golden_vectornav_ypr());
      ASSERT_EQ(messages.size(), 1U) << bit;
      ASSERT_EQ(messages[0].fields.common, 8) << bit;
    }
  }
}

}  // namespace
}  // namespace soak::hal::imu::test
