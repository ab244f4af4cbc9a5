// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "tests/hal/decoder_wires.h"

namespace soak::hal::imu::test {
namespace {

std::vector<Ahrs400Packet> decoded_ahrs400(const Bytes& bytes) {
  Ahrs400Decoder decoder;
  std::vector<Ahrs400Packet> packets;
  decoder.append(bytes);
  while (const auto packet = decoder.next()) packets.push_back(*packet);
  return packets;
}

std::vector<std::uint16_t> timers(const std::vector<Ahrs400Packet>& packets) {
  std::vector<std::uint16_t> all;
  for (const Ahrs400Packet& packet : packets) all.push_back(packet.timer);
  return all;
}

TEST(Ahrs400Decoder, ReadsTheWorkedPacket) {
  const auto packets = decoded_ahrs400(golden_ahrs400() + golden_ahrs400());
  ASSERT_EQ(packets.size(), 2U);
  const Ahrs400Packet& packet = packets[0];
  EXPECT_NEAR(ahrs400_scaled(packet.rate[0], 100.0), 1.0, 0.005);
  EXPECT_NEAR(ahrs400_scaled(packet.rate[1], 100.0), -2.0, 0.005);
  EXPECT_NEAR(ahrs400_scaled(packet.rate[2], 100.0), 0.5, 0.005);
  EXPECT_EQ(packet.accel[0], 0);
  EXPECT_NEAR(ahrs400_scaled(packet.accel[2], 2.0), -1.0, 1e-4);
  EXPECT_NEAR(ahrs400_temp_c(packet.temp), 25.0, 0.05);
  EXPECT_EQ(packet.timer, 65535);
}

TEST(Ahrs400Decoder, FullScaleIsOneAndAHalfTimesTheRange) {
  EXPECT_DOUBLE_EQ(ahrs400_scaled(-32768, 200.0), -300.0);
  EXPECT_TRUE(at_rail(32767) && at_rail(-32768) && at_rail(-32767));
  EXPECT_FALSE(at_rail(32766) || at_rail(0));
}

TEST(Ahrs400Decoder, OnePacketAloneIsNotBelievedAfterALoss) {
  EXPECT_TRUE(decoded_ahrs400(golden_ahrs400()).empty());
  EXPECT_TRUE(decoded_ahrs400(golden_ahrs400() + Bytes(48, 0x11)).empty());
}

TEST(Ahrs400Decoder, OnlyTheFirstPacketAfterALossSaysSo) {
  const auto packets = decoded_ahrs400(Ahrs400Wire::stream(3) + hex("00 01 02") + Ahrs400Wire::stream(3, 3));
  // The last packet before the garbage is followed by no header: it is part of the loss.
  ASSERT_EQ(timers(packets), (std::vector<std::uint16_t>{0, 1, 3, 4, 5}));
  EXPECT_TRUE(packets[0].after_loss && packets[2].after_loss);
  EXPECT_FALSE(packets[1].after_loss || packets[3].after_loss || packets[4].after_loss);
}

TEST(Ahrs400Decoder, EverySingleFlippedBitCostsOnePacketOrTwo) {
  const Bytes good = Ahrs400Wire::stream(7);
  for (std::size_t bit = 0; bit < 8 * 24; ++bit) {
    Bytes damaged = good;
    damaged[3 * 24 + bit / 8] = static_cast<std::uint8_t>(damaged[3 * 24 + bit / 8] ^ (1U << (bit % 8)));
    const auto seen = timers(decoded_ahrs400(damaged));
    // The header of the damaged packet also vouches for the one before.
    const bool header = bit < 8;
    const std::vector<std::uint16_t> expected =
        header ? std::vector<std::uint16_t>{0, 1, 4, 5, 6} : std::vector<std::uint16_t>{0, 1, 2, 4, 5, 6};
    ASSERT_EQ(seen, expected) << bit;
  }
}

}  // namespace
}  // namespace soak::hal::imu::test
