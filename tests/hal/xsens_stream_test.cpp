// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.h"
#include "tests/errors.h"
#include "tests/hal/unit_benches.h"
#include "tests/hal/xsens_golden.h"

namespace soak::hal::imu::test {
namespace {

class XsensStream : public InStream<XsensBench> {};

TEST_F(XsensStream, PacketsBecomeSamples) {
  send_and_step(bench.unit.packets(25));
  ASSERT_EQ(bench.samples.size(), 25U);
  for (std::uint32_t i = 0; i < 25; ++i) {
    const ImuSample& sample = bench.samples[i];
    const auto number = static_cast<float>(i);
    EXPECT_DOUBLE_EQ(sample.t_s, 0.01 * i);
    EXPECT_EQ(sample.packet, i);
    EXPECT_EQ(sample.accel_mps2, (std::array<float, 3>{number, -number, 9.8F}));
    EXPECT_EQ(sample.rate_rps, (std::array<float, 3>{0.5F * number, 0.25F, -0.125F}));
    EXPECT_EQ(sample.temp_c, i % 10 == 0 ? std::optional(20.0F + number) : std::nullopt);
    EXPECT_EQ(sample.status, 0x00400003U);
    EXPECT_FALSE(sample.clipped);
  }
  EXPECT_EQ(bench.imu->statistics().packets, 25U);
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 0U);
}

TEST_F(XsensStream, GoldenPacketsAreTakenAndAPacketWithoutAccelerationIsNoSample) {
  send_and_step(golden_with_temperature());
  ASSERT_EQ(bench.samples.size(), 1U);
  EXPECT_DOUBLE_EQ(bench.samples[0].t_s, 2033.2454);
  EXPECT_EQ(bench.samples[0].packet, 37261U);
  EXPECT_EQ(bench.samples[0].temp_c, 37.625F);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
  send_and_step(golden_short());
  EXPECT_EQ(bench.samples.size(), 1U);
}

TEST_F(XsensStream, ATemperatureWithoutASampleIsCarriedToTheNextOne) {
  const Bytes stamp = item(0x1020, u16(0)) + item(0x1060, u32(0));
  bench.unit.counter = 1;
  bench.unit.ticks = 100;
  send_and_step(frame(0x36, stamp + item(0x0810, f32(-12.5F))) + bench.unit.packets(2));
  ASSERT_EQ(bench.samples.size(), 2U);
  EXPECT_EQ(bench.samples[0].temp_c, -12.5F);
  EXPECT_FALSE(bench.samples[1].temp_c);
}

TEST_F(XsensStream, AUnitWhoseClockStandsStillGivesNoSamples) {
  send_and_step(bench.unit.packets(3));
  const std::uint32_t stopped = bench.unit.ticks;
  for (int i = 0; i < 10; ++i) {
    bench.unit.ticks = stopped;
    send_and_step(bench.unit.packet());
  }
  ASSERT_EQ(bench.samples.size(), 4U);
  EXPECT_LT(bench.samples[2].t_s, bench.samples[3].t_s);
}

TEST_F(XsensStream, GarbageBetweenPacketsIsCountedAndCostsNoSample) {
  for (int i = 0; i < 50; ++i) send_and_step(hex("01 FA 02 FA FF 36 05") + bench.unit.packet());
  send_and_step(Bytes(300, 0));
  EXPECT_EQ(bench.samples.size(), 50U);
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 50U * 7U + 300U);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
}

TEST_F(XsensStream, AMalformedPacketCountsAsGarbage) {
  const Bytes malformed = frame(0x36, hex("40 20 0C 00"));
  send_and_step(malformed + bench.unit.packet());
  EXPECT_EQ(bench.samples.size(), 1U);
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, malformed.size());
}

TEST_F(XsensStream, ClippingIsReported) {
  const Bytes head = item(0x1020, u16(0)) + item(0x1060, u32(0));
  const Bytes vectors = item(0x4020, Bytes(12, 0)) + item(0x8020, Bytes(12, 0));
  send_and_step(frame(0x36, head + vectors + item(0xE020, u32(0x00080103))));
  ASSERT_EQ(bench.samples.size(), 1U);
  EXPECT_TRUE(bench.samples[0].clipped);
  EXPECT_EQ(bench.samples[0].status, 0x00080103U);
}

TEST_F(XsensStream, AWakeUpBeginsANewPowerOnAndConfiguresAgain) {
  const Bytes before = bench.unit.packets(5);
  const Bytes wake_up = bench.unit.restart();
  bench.unit.serial = 0x0380EEEE;
  const Bytes unconfigured = bench.unit.packets(3);
  send_and_step(before + wake_up + unconfigured);
  EXPECT_EQ(bench.power_ons(), std::vector<std::uint32_t>(5, 0));
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.unit.heard, (std::vector<unsigned>{0x3F, 0x30, 0x00, 0x1C, 0x12, 0xC0, 0x10}));
  EXPECT_EQ(bench.imu->identity()->serial, "0380EEEE");
  send_and_step(bench.unit.packets(2));
  EXPECT_EQ(bench.power_ons(), (std::vector<std::uint32_t>{0, 0, 0, 0, 0, 1, 1}));
  EXPECT_DOUBLE_EQ(bench.samples.back().t_s, 0.04);
  EXPECT_EQ(bench.imu->statistics().restarts, 1U);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
}

TEST_F(XsensStream, DeviceTimeThatBeginsAnewIsARestart) {
  const Bytes before = bench.unit.packets(500);
  static_cast<void>(bench.unit.restart());
  send_and_step(before + bench.unit.packets(20));
  EXPECT_EQ(bench.power_ons(), std::vector<std::uint32_t>(500, 0));
  ASSERT_TRUE(bench.settle());
  send_and_step(bench.unit.packets(1));
  EXPECT_EQ(bench.samples.back().power_on, 1U);
  EXPECT_DOUBLE_EQ(bench.samples.back().t_s, 0.2);
  EXPECT_EQ(bench.imu->statistics().restarts, 1U);
}

TEST_F(XsensStream, ARestartDuringAnInterruptionOfTheLinkIsNoticed) {
  send_and_step(bench.unit.packets(500));
  bench.imu->close();
  static_cast<void>(bench.unit.restart());
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.settle());
  send_and_step(bench.unit.packets(3));
  EXPECT_EQ(bench.samples.size(), 503U);
  EXPECT_EQ(bench.samples.back().power_on, 1U);
  EXPECT_DOUBLE_EQ(bench.samples.back().t_s, 0.02);
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
}

TEST_F(XsensStream, SilenceIsReportedAndTheStreamGoesOnByItself) {
  send_and_step(bench.unit.packets(5));
  ASSERT_TRUE(bench.pass(2.9));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  ASSERT_TRUE(bench.pass(0.2));
  EXPECT_EQ(bench.imu->state(), ImuState::silent);
  ASSERT_TRUE(bench.pass(20.0));
  send_and_step(bench.unit.packets(5));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  EXPECT_EQ(bench.power_ons(), std::vector<std::uint32_t>(10, 0));
  EXPECT_TRUE(bench.unit.heard.empty());
}

TEST_F(XsensStream, SilenceAndThenAWakeUpIsOneRestart) {
  send_and_step(bench.unit.packets(5));
  bench.unit.answers = false;
  ASSERT_TRUE(bench.pass(100.0));
  EXPECT_EQ(bench.imu->state(), ImuState::silent);
  bench.unit.answers = true;
  bench.send(bench.unit.restart());
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  send_and_step(bench.unit.packets(2));
  EXPECT_EQ(bench.power_ons(), (std::vector<std::uint32_t>{0, 0, 0, 0, 0, 1, 1}));
  EXPECT_EQ(bench.imu->statistics().restarts, 1U);
}

TEST_F(XsensStream, AWakeUpBehindAFrameThatThePowerCutIsFound) {
  const Bytes whole = bench.unit.packets(2);
  send_and_step(Bytes(whole.begin(), whole.end() - 20));
  ASSERT_TRUE(bench.pass(1.0));
  bench.send(bench.unit.restart());
  ASSERT_TRUE(bench.settle());
  send_and_step(bench.unit.packets(1));
  EXPECT_EQ(bench.power_ons(), (std::vector<std::uint32_t>{0, 1}));
}

TEST_F(XsensStream, ACounterThatBeginsAnewIsARestartAlthoughTheTimeGoesOn) {
  send_and_step(bench.unit.packets(500));
  bench.unit.counter = 0;
  send_and_step(bench.unit.packets(1));
  ASSERT_TRUE(bench.settle());
  send_and_step(bench.unit.packets(1));
  EXPECT_EQ(bench.samples.size(), 501U);
  EXPECT_EQ(bench.samples.back().power_on, 1U);
}

TEST_F(XsensStream, AUnitThatComesBackWithAnotherConfigurationIsConfiguredAgain) {
  send_and_step(bench.unit.packets(500));
  static_cast<void>(bench.unit.restart());
  bench.unit.ticks = 20;
  const Bytes attitude = frame(0x36, item(0x2010, Bytes(16, 0)));  // as the factory has set it, say
  for (int i = 0; i < 40 && !bench.unit.measuring; ++i) {
    bench.send(attitude);
    ASSERT_TRUE(bench.pass(0.1));
  }
  EXPECT_TRUE(bench.unit.measuring);
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  send_and_step(bench.unit.packets(1));
  EXPECT_EQ(bench.samples.size(), 501U);
  EXPECT_EQ(bench.samples.back().power_on, 1U);
  EXPECT_DOUBLE_EQ(bench.samples.back().t_s, 0.002);
}

TEST_F(XsensStream, AUnitThatDoesNotKeepToItsConfigurationFails) {
  base::Status status;
  for (int i = 0; i < 40 && status; ++i) {
    bench.send(frame(0x36, item(0x2010, Bytes(16, 0))));
    status = bench.pass(0.1);
  }
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  EXPECT_EQ(bench.imu->state(), ImuState::failed);
}

TEST_F(XsensStream, AMessageWithoutASampleAfterASilenceDisturbsNothing) {
  send_and_step(bench.unit.packets(5));
  ASSERT_TRUE(bench.pass(20.0));
  send_and_step(frame(0x36, item(0x0810, f32(21.0F))));
  send_and_step(bench.unit.packets(1));
  EXPECT_TRUE(bench.unit.heard.empty());
  EXPECT_EQ(bench.samples.size(), 6U);
}

TEST_F(XsensStream, AnotherBaudRateInTheMiddleIsSilenceThenAFailure) {
  send_and_step(bench.unit.packets(5));
  bench.unit.answers = false;
  base::Random random(7);
  base::Status status;
  int tenths = 0;
  for (; tenths < 600 && status; ++tenths) {
    Bytes noise(30);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random.next() % 0xFA);  // no frame by chance
    bench.send(noise);
    status = bench.pass(0.1);
    if (tenths == 100) {
      EXPECT_EQ(bench.imu->state(), ImuState::silent);
    }
  }
  EXPECT_TRUE(is_device_error(status, {"(30)"}));
  EXPECT_NEAR(tenths, 340, 10);  // 30 s of patience, then four requests of 1 s
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 30U * static_cast<unsigned>(tenths));
}

TEST_F(XsensStream, AnErrorMessageInTheStreamFails) {
  bench.send(frame(0x42, {30}));
  const auto status = bench.step();
  ASSERT_FALSE(status);
  EXPECT_TRUE(names(status.error(), {"30"}));
}

TEST_F(XsensStream, APollReadsAtMost64KibAndLosesNothing) {
  const Bytes backlog = bench.unit.packets(4000);
  ASSERT_GT(backlog.size(), 3U * 65536U);
  bench.send(backlog);
  std::size_t before = 0;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(bench.imu->poll(bench.samples));
    EXPECT_LE((bench.samples.size() - before) * 54, 65536U + 54U);
    before = bench.samples.size();
  }
  EXPECT_EQ(bench.samples.size(), 4000U);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
}

TEST_F(XsensStream, TimeIsNotUpWhileABacklogHidesTheAnswer) {
  bench.imu->close();
  ASSERT_TRUE(bench.open());
  const Bytes backlog = bench.unit.packets(5000);
  bench.send(backlog);
  for (int i = 0; i < 20; ++i) {
    bench.now += std::chrono::seconds(2);  // a station that hardly finds the time to poll
    ASSERT_TRUE(bench.step());
  }
  EXPECT_TRUE(bench.unit.measuring);
  EXPECT_EQ(std::ranges::count(bench.unit.heard, 0x30U), 1);
}

TEST_F(XsensStream, SurvivesHostileBytes) {
  base::Random random(42);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = bench.unit.packets(3) + frame(random.next() % 256, Bytes(random.next() % 8, 0x10));
    for (std::uint64_t i = random.next() % 4; i > 0; --i) {
      bytes[random.next() % bytes.size()] = static_cast<std::uint8_t>(random.next());
    }
    bench.send(bytes);
    bench.now += std::chrono::milliseconds(random.next() % 400);
    if (!bench.step()) {
      ASSERT_TRUE(bench.open());
      ASSERT_TRUE(bench.step());
    }
  }
  EXPECT_GT(bench.imu->statistics().packets, 1000U);
  EXPECT_GT(bench.imu->statistics().restarts, 0U);
  EXPECT_EQ(bench.imu->statistics().packets, bench.samples.size());
  EXPECT_TRUE(std::ranges::is_sorted(bench.power_ons()));
}

}  // namespace
}  // namespace soak::hal::imu::test
