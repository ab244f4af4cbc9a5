// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "base/random.h"
#include "hal/imu/detail/ahrs400_decoder.h"
#include "tests/hal/ahrs400_peer.h"

namespace soak::hal::imu::test {
namespace {

void drain(Ahrs400Decoder& decoder, std::vector<Ahrs400Packet>& packets) {
  while (const auto packet = decoder.next()) packets.push_back(*packet);
}

std::vector<Ahrs400Packet> decode(const Bytes& bytes) {
  Ahrs400Decoder decoder;
  std::vector<Ahrs400Packet> packets;
  decoder.append(bytes);
  drain(decoder, packets);
  return packets;
}

std::vector<std::uint16_t> timers(const std::vector<Ahrs400Packet>& packets) {
  std::vector<std::uint16_t> all;
  for (const Ahrs400Packet& packet : packets) all.push_back(packet.timer);
  return all;
}

/// Packets of rising number in their rates, with FF all over them.
Bytes stream(int count, int first = 0) {
  Bytes all;
  for (int i = first; i < first + count; ++i) all = all + ahrs400_packet({i, -1, -1, -256, 255, -1, 0, 0, 0, 0, i});
  return all;
}

TEST(Ahrs400Decoder, ReadsTheWorkedPacket) {
  const auto packets = decode(golden_ahrs400() + golden_ahrs400());
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

TEST(Ahrs400Decoder, EverySplitOfTheStreamGivesTheSamePackets) {
  const Bytes bytes = hex("12 FF 00") + stream(4) + hex("FF FF FF") + stream(4, 4) + hex("FF 01");
  const auto expected = timers(decode(bytes));
  EXPECT_EQ(expected.size(), 8U);
  for (std::size_t split = 0; split <= bytes.size(); ++split) {
    Ahrs400Decoder decoder;
    std::vector<Ahrs400Packet> packets;
    decoder.append(std::span(bytes).first(split));
    drain(decoder, packets);
    decoder.append(std::span(bytes).subspan(split));
    drain(decoder, packets);
    // A packet at the very end of the first part is believed before the garbage behind it is there.
    ASSERT_EQ(timers(packets), expected) << split;
  }
}

TEST(Ahrs400Decoder, ByteByByteGivesEveryPacketAndCountsTheGarbage) {
  const Bytes bytes = hex("FF 22") + stream(5);
  Ahrs400Decoder decoder;
  std::vector<Ahrs400Packet> packets;
  for (const std::uint8_t byte : bytes) {
    decoder.append(std::span(&byte, 1));
    drain(decoder, packets);
  }
  EXPECT_EQ(packets.size(), 5U);
  EXPECT_EQ(decoder.garbage_bytes(), 2U);
}

TEST(Ahrs400Decoder, OnePacketAloneIsNotBelievedAfterALoss) {
  EXPECT_TRUE(decode(golden_ahrs400()).empty());
  EXPECT_TRUE(decode(golden_ahrs400() + Bytes(48, 0x11)).empty());
}

TEST(Ahrs400Decoder, OnlyTheFirstPacketAfterALossSaysSo) {
  const auto packets = decode(stream(3) + hex("00 01 02") + stream(3, 3));
  // The last packet before the garbage is followed by no header: it is part of the loss.
  ASSERT_EQ(timers(packets), (std::vector<std::uint16_t>{0, 1, 3, 4, 5}));
  EXPECT_TRUE(packets[0].after_loss && packets[2].after_loss);
  EXPECT_FALSE(packets[1].after_loss || packets[3].after_loss || packets[4].after_loss);
}

TEST(Ahrs400Decoder, EverySingleFlippedBitCostsOnePacketOrTwo) {
  const Bytes good = stream(7);
  for (std::size_t bit = 0; bit < 8 * 24; ++bit) {
    Bytes damaged = good;
    damaged[3 * 24 + bit / 8] = static_cast<std::uint8_t>(damaged[3 * 24 + bit / 8] ^ (1U << (bit % 8)));
    const auto seen = timers(decode(damaged));
    // The header of the damaged packet also vouches for the one before.
    const bool header = bit < 8;
    const std::vector<std::uint16_t> expected =
        header ? std::vector<std::uint16_t>{0, 1, 4, 5, 6} : std::vector<std::uint16_t>{0, 1, 2, 4, 5, 6};
    ASSERT_EQ(seen, expected) << bit;
  }
}

TEST(Ahrs400Decoder, AccountsForEveryRandomByteInBoundedMemory) {
  base::Random random(3);
  Ahrs400Decoder decoder;
  std::uint64_t fed = 0;
  std::uint64_t framed = 0;
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes = round % 3 == 0 ? stream(static_cast<int>(random.next() % 9)) : Bytes{};
    for (std::uint64_t i = random.next() % 200; i > 0; --i) {
      bytes.push_back(random.next() % 3 == 0 ? 0xFF : static_cast<std::uint8_t>(random.next()));
    }
    decoder.append(bytes);
    fed += bytes.size();
    while (decoder.next()) framed += kAhrs400PacketSize;
    ASSERT_LT(decoder.pending_bytes(), 2 * kAhrs400PacketSize);
    ASSERT_EQ(decoder.garbage_bytes() + framed + decoder.pending_bytes(), fed);
  }
  EXPECT_GT(framed, fed / 10);
}

}  // namespace
}  // namespace soak::hal::imu::test
