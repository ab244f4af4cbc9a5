// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/random.h"
#include "hal/imu/detail/xsens_frames.h"
#include "tests/hal/xsens_golden.h"
#include "tests/hal/xsens_peer.h"

namespace soak::hal::imu::test {
namespace {

Bytes payload_of(const Bytes& whole) { return Bytes(whole.begin() + 4, whole.end() - 1); }

TEST(MtData2, DecodesThePacketWithTemperatureAsMtManagerDoes) {
  const auto packet = decode_mt_data2(payload_of(golden_with_temperature()));
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->packet_counter, 37261);
  EXPECT_EQ(packet->sample_time_fine, 20332454U);
  ASSERT_TRUE(packet->accel_mps2 && packet->rate_rps && packet->temp_c);
  // MT Manager prints seven decimals.
  EXPECT_NEAR((*packet->accel_mps2)[0], -0.0555063, 5e-8);
  EXPECT_NEAR((*packet->accel_mps2)[1], 9.8146553, 5e-7);
  EXPECT_NEAR((*packet->accel_mps2)[2], 0.2184231, 5e-8);
  EXPECT_NEAR((*packet->rate_rps)[0], 0.0213176, 5e-8);
  EXPECT_NEAR((*packet->rate_rps)[1], -0.0032783, 5e-8);
  EXPECT_NEAR((*packet->rate_rps)[2], -0.0016302, 5e-8);
  EXPECT_EQ(packet->temp_c, 37.625F);
  EXPECT_EQ(packet->status, 0x00400003U);
}

TEST(MtData2, DecodesTheShortPacketAsMtManagerDoes) {
  const auto packet = decode_mt_data2(payload_of(golden_short()));
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->packet_counter, 18050);
  EXPECT_EQ(packet->sample_time_fine, 29686846U);
  EXPECT_FALSE(packet->accel_mps2 || packet->rate_rps || packet->temp_c);
}

TEST(MtData2, TakesEveryNumberFormat) {
  const auto temp = [](unsigned id, const Bytes& value) { return decode_mt_data2(item(id, value))->temp_c; };
  EXPECT_EQ(temp(0x0810, f32(-40.5F)), -40.5F);
  EXPECT_EQ(temp(0x0811, hex("FD 78 00 00")), -40.5F);              // -40.5·2^20 = 0xFD780000
  EXPECT_EQ(temp(0x0812, hex("80 00 00 00 FF D7")), -40.5F);        // fraction 0.5, whole part -41
  EXPECT_EQ(temp(0x0813, hex("C0 44 40 00 00 00 00 00")), -40.5F);  // -40.5 as float64
  EXPECT_EQ(temp(0x0814, f32(25.0F)), 25.0F);                       // another frame of reference
}

TEST(MtData2, TakesVectorsInWideFormats) {
  const auto packet = decode_mt_data2(item(0x4022, hex("40 00 00 00 00 09 80 00 00 00 FF FF 00 00 00 00 7F FF")));
  ASSERT_TRUE(packet && packet->accel_mps2);
  EXPECT_EQ(*packet->accel_mps2, (std::array<float, 3>{9.25F, -0.5F, 32767.0F}));
}

TEST(MtData2, SkipsWhatItDoesNotKnow) {
  const auto packet = decode_mt_data2(item(0xABC0, Bytes(200, 7)) + item(0x0810, f32(1.0F)) + item(0x5040, {}));
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->temp_c, 1.0F);
}

TEST(MtData2, EveryCutInsideAnElementIsMalformed) {
  const Bytes whole = item(0x1020, u16(7)) + item(0x0810, f32(1.0F));
  for (std::size_t size = 1; size < whole.size(); ++size) {
    const bool between_elements = size == 5;
    EXPECT_EQ(decode_mt_data2(std::span(whole).first(size)).has_value(), between_elements) << size;
  }
}

TEST(MtData2, ASizeThatTheIdentifierDoesNotAllowIsMalformed) {
  for (const unsigned id : {0x1020U, 0x1060U, 0x4020U, 0x8023U, 0x0812U, 0xE020U}) {
    EXPECT_FALSE(decode_mt_data2(item(id, Bytes(5, 0)))) << id;
    EXPECT_FALSE(decode_mt_data2(item(id, {}))) << id;
  }
}

TEST(MtData2, ClippingIsReadFromBits8To13And19) {
  for (unsigned bit = 0; bit < 32; ++bit) {
    EXPECT_EQ(says_clipped(1U << bit), (bit >= 8 && bit <= 13) || bit == 19) << bit;
  }
}

// Bit 19 stands for the magnetometers as well, which nobody records here.
TEST(MtData2, AMagnetometerAtItsRailIsNoClipping) {
  constexpr std::uint32_t any = 1U << 19U;
  for (unsigned bit = 14; bit <= 16; ++bit) {
    EXPECT_FALSE(says_clipped(any | 1U << bit)) << bit;
    EXPECT_TRUE(says_clipped(any | 1U << bit | 1U << 8U)) << "and an accelerometer beside it";
    EXPECT_TRUE(says_clipped(any | 1U << bit | 1U << 13U)) << "and a gyro beside it";
  }
}

TEST(MtData2, SurvivesRandomPayloads) {
  base::Random random(7);
  const Bytes golden = payload_of(golden_with_temperature());
  int decoded = 0;
  for (int round = 0; round < 20000; ++round) {
    Bytes damaged = golden;
    damaged.resize(random.next() % (golden.size() + 1));
    for (int i = 0; i < round % 4 && !damaged.empty(); ++i) {
      damaged[random.next() % damaged.size()] = static_cast<std::uint8_t>(random.next());
    }
    // A copy of exactly this size: a sanitizer sees any read past its end.
    decoded += decode_mt_data2(Bytes(damaged)).has_value() ? 1 : 0;
  }
  EXPECT_GT(decoded, 100);
  EXPECT_LT(decoded, 19900);
}

}  // namespace
}  // namespace soak::hal::imu::test
