// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/hal/unit_benches.h"

namespace soak::hal::imu::test {
namespace {

/// Driver and unit in the middle of a stream.
class Ahrs400Stream : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(bench.open());
    ASSERT_TRUE(bench.pass(2.0, 0.05));
    ASSERT_TRUE(bench.unit.continuous);
    ASSERT_EQ(bench.imu->state(), ImuState::streaming);
    bench.unit.heard.clear();
  }

  /// Host and unit live through `count` packets, one every 15.5 ms.
  void stream(int count, double step_s = AhrsBench::kStep_s) {
    for (int i = 0; i < count; ++i) {
      bench.now += std::chrono::round<AhrsBench::Clock::duration>(std::chrono::duration<double>(step_s));
      bench.send(bench.unit.packets(1, step_s));
      ASSERT_TRUE(bench.step());
    }
  }

  /// Both let time pass; the unit sends nothing.
  void silence(double seconds) {
    bench.pause_unit(seconds);
    ASSERT_TRUE(bench.pass(seconds, 0.02));
  }

  [[nodiscard]] double span_s() const { return bench.samples.back().t_s - bench.samples.front().t_s; }

  AhrsBench bench;
};

TEST(Ahrs400Setup, PingsIdentifiesAndStartsTheUnit) {
  AhrsBench bench;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.pass(2.0, 0.05));
  EXPECT_EQ(bench.unit.heard, "RSvcC");
  EXPECT_EQ(bench.unit.mode, 's');
  EXPECT_TRUE(bench.unit.continuous);
  EXPECT_EQ(bench.imu->identity()->serial, "9911750");
  EXPECT_EQ(bench.imu->identity()->product, "AHRS400CC-100 ver 1.15");
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
}

TEST(Ahrs400Setup, TakesASerialNumberWithoutHeader) {
  AhrsBench bench;
  bench.unit.bare_serial = true;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.pass(2.0, 0.05));
  EXPECT_EQ(bench.imu->identity()->serial, "9911750");
}

TEST(Ahrs400Setup, AUnitThatStillStreamsIsStoppedAndAskedAndStreamsAgain) {
  AhrsBench bench;
  bench.unit.mode = 's';
  bench.unit.continuous = true;
  ASSERT_TRUE(bench.open());
  for (int i = 0; i < 100; ++i) {
    bench.now += std::chrono::milliseconds(20);
    if (bench.unit.continuous && i < 30) bench.send(bench.unit.packets(1, 0.02));
    ASSERT_TRUE(bench.step());
  }
  EXPECT_EQ(bench.unit.heard, "RSvcC");
  EXPECT_EQ(bench.imu->identity()->serial, "9911750");
  EXPECT_EQ(bench.imu->statistics().restarts, 0U);
}

TEST_F(Ahrs400Stream, PacketsBecomeSamplesInSi) {
  stream(20);
  ASSERT_EQ(bench.samples.size(), 20U);
  const ImuSample& sample = bench.samples[10];
  EXPECT_NEAR(sample.rate_rps[0], 10 * 150.0 / 32768 * std::numbers::pi / 180.0, 1e-6);
  EXPECT_NEAR(sample.accel_mps2[2], -9.80665, 1e-3);
  EXPECT_EQ(sample.accel_mps2[0], 0.0F);
  EXPECT_FALSE(sample.clipped);
  EXPECT_NEAR(span_s(), 19 * 0.0155, 1e-5);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 0U);
}

TEST_F(Ahrs400Stream, ReadingsOfTheThermometerComeAtTheRateAskedFor) {
  stream(645);  // 10 s
  const auto readings = std::count_if(bench.samples.begin(), bench.samples.end(),
                                      [](const ImuSample& sample) { return sample.temp_c.has_value(); });
  EXPECT_NEAR(static_cast<double>(readings), 100.0, 2.0);
  EXPECT_NEAR(*bench.samples.front().temp_c, 25.0, 0.05);
}

TEST_F(Ahrs400Stream, ANumberAtFullScaleIsClipped) {
  stream(3);
  bench.unit.time_s += 0.0155;
  const int timer = 65535 - static_cast<int>(static_cast<std::uint64_t>(bench.unit.time_s / 0.79e-6) % 65536);
  bench.send(ahrs400_packet({0, 32767, 0, 0, 0, 0, 0, 0, 0, 0, timer}));
  ASSERT_TRUE(bench.step());
  EXPECT_TRUE(bench.samples.back().clipped);
}

TEST_F(Ahrs400Stream, TheTimeFollowsManyWrapsOfTheTimerOnAnUnevenGrid) {
  double length_s = 0.0;
  stream(1);
  for (int i = 0; i < 3000; ++i) {
    const double step_s = i % 3 == 0 ? 0.0195 : 0.0135;
    length_s += step_s;
    stream(1, step_s);
  }
  EXPECT_NEAR(span_s(), length_s, 1e-4);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
}

TEST_F(Ahrs400Stream, AGapOfManyWrapsIsMeasuredByTheHostAndStampedByTheUnit) {
  for (const double gap_s : {0.04, 0.08, 0.31, 2.0}) {
    stream(50);
    const double before_s = bench.samples.back().t_s;
    silence(gap_s);
    stream(1);
    EXPECT_NEAR(bench.samples.back().t_s - before_s, gap_s + 0.0155, 1e-5) << gap_s;
  }
}

TEST_F(Ahrs400Stream, ADamagedPacketIsLostAndTwoGoodOnesEndTheSearch) {
  stream(20);
  Bytes damaged = bench.unit.packets(1);
  damaged[5] ^= 0x40;
  bench.now += std::chrono::microseconds(15500);
  bench.send(damaged);
  ASSERT_TRUE(bench.step());
  stream(1);
  EXPECT_EQ(bench.samples.size(), 20U);
  stream(1);
  EXPECT_EQ(bench.samples.size(), 22U);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 1U);
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 24U);
  EXPECT_NEAR(span_s(), 22 * 0.0155, 1e-4);
}

TEST_F(Ahrs400Stream, ABusyStationThatReadsLateGivesTheSameTimes) {
  stream(50);
  bench.send(bench.unit.packets(130));
  bench.now += std::chrono::milliseconds(2015);  // all of it waited in the kernel
  ASSERT_TRUE(bench.step());
  stream(20);
  ASSERT_EQ(bench.samples.size(), 200U);
  EXPECT_NEAR(span_s(), 199 * 0.0155, 1e-4);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
}

TEST_F(Ahrs400Stream, ABacklogThatABufferCutOffHasItsGapBehindIt) {
  stream(50);
  bench.send(bench.unit.packets(100));
  static_cast<void>(bench.unit.packets(60));  // the buffer was full
  bench.now += std::chrono::microseconds(160 * 15500);
  ASSERT_TRUE(bench.step());
  stream(20);
  ASSERT_EQ(bench.samples.size(), 170U);
  EXPECT_NEAR(bench.samples[149].t_s - bench.samples[0].t_s, 149 * 0.0155, 1e-4);
  EXPECT_NEAR(bench.samples[150].t_s - bench.samples[149].t_s, 61 * 0.0155, 1e-4);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 60U);
  EXPECT_EQ(bench.samples[149].lost, 0U);
  EXPECT_EQ(bench.samples[150].lost, 60U);
}

TEST_F(Ahrs400Stream, AClockThatRunsOnePercentSlowShowsNoGaps) {
  for (int i = 0; i < 4000; ++i) {
    bench.now += std::chrono::microseconds(15655);
    bench.send(bench.unit.packets(1, 0.0155));
    ASSERT_TRUE(bench.step());
  }
  EXPECT_NEAR(span_s(), 3999 * 0.0155, 1e-3);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
}

}  // namespace
}  // namespace soak::hal::imu::test
