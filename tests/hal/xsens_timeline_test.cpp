// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hal/imu/detail/xsens_protocol.h"

namespace soak::hal::imu::test {
namespace {

PacketTimeline at_100_hz() {
  PacketTimeline timeline;
  timeline.interrupt(100.0);
  return timeline;
}

TEST(PacketTimeline, TimeGoesOnBeyondTheWrapOf32Bits) {
  PacketTimeline timeline = at_100_hz();
  ASSERT_TRUE(timeline.advance({.counter = 1, .time_fine = 0xFFFF'FFCE}));  // 50 ticks before the wrap
  EXPECT_DOUBLE_EQ(timeline.time_s(), 429496.7246);
  ASSERT_TRUE(timeline.advance({.counter = 2, .time_fine = 50}));
  EXPECT_DOUBLE_EQ(timeline.time_s(), 429496.7346);
  EXPECT_EQ(timeline.lost_packets(), 0U);
}

TEST(PacketTimeline, TwoWrapsAddUp) {
  PacketTimeline timeline = at_100_hz();
  std::uint32_t ticks = 0;
  std::uint16_t counter = 0;
  const std::uint32_t hour = 36'000'000;
  for (int i = 0; i <= 300; ++i) {  // 300 h: 2.5 wraps
    ASSERT_TRUE(timeline.advance({counter, ticks})) << i;
    ticks += hour;
    counter = static_cast<std::uint16_t>(counter + 360'000);
  }
  EXPECT_DOUBLE_EQ(timeline.time_s(), 300.0 * 3600.0);
}

TEST(PacketTimeline, GapsOfTheCounterAreLostPackets) {
  PacketTimeline timeline = at_100_hz();
  ASSERT_TRUE(timeline.advance({.counter = 65533, .time_fine = 1000}));
  EXPECT_EQ(timeline.lost_packets(), 0U);
  ASSERT_TRUE(timeline.advance({.counter = 65534, .time_fine = 1100}));
  EXPECT_EQ(timeline.lost_packets(), 0U);
  ASSERT_TRUE(timeline.advance({.counter = 2, .time_fine = 1500}));  // 65535, 0 and 1 are missing
  EXPECT_EQ(timeline.lost_packets(), 3U);
  ASSERT_TRUE(timeline.advance({.counter = 3, .time_fine = 1600}));
  EXPECT_EQ(timeline.lost_packets(), 0U);
}

TEST(PacketTimeline, TimeThatRunsBackwardsBeginsAnew) {
  PacketTimeline timeline = at_100_hz();
  ASSERT_TRUE(timeline.advance({.counter = 5000, .time_fine = 500'000}));
  EXPECT_FALSE(timeline.advance({.counter = 0, .time_fine = 0}));
  EXPECT_DOUBLE_EQ(timeline.time_s(), 50.0);
  timeline.restart_clock();
  EXPECT_TRUE(timeline.empty());
  ASSERT_TRUE(timeline.advance({.counter = 0, .time_fine = 25}));
  EXPECT_DOUBLE_EQ(timeline.time_s(), 0.0025);
  EXPECT_EQ(timeline.lost_packets(), 0U);
}

TEST(PacketTimeline, ACounterThatBeginsAnewIsNoticedAlthoughTheTimeHasMovedOn) {
  PacketTimeline timeline = at_100_hz();
  ASSERT_TRUE(timeline.advance({.counter = 10, .time_fine = 1000}));
  EXPECT_FALSE(timeline.advance({.counter = 0, .time_fine = 3000}));
}

TEST(PacketTimeline, ALongGapIsNoRestartWhileCounterAndTimeAgree) {
  PacketTimeline timeline = at_100_hz();
  ASSERT_TRUE(timeline.advance({.counter = 10, .time_fine = 1000}));
  ASSERT_TRUE(timeline.advance({.counter = 60010, .time_fine = 6'001'000}));
  EXPECT_EQ(timeline.lost_packets(), 59999U);
}

TEST(PacketTimeline, AfterAnInterruptionTheCounterMayHaveAnyValue) {
  PacketTimeline timeline = at_100_hz();
  ASSERT_TRUE(timeline.advance({.counter = 1000, .time_fine = 100'000}));
  timeline.interrupt(100.0);
  ASSERT_TRUE(timeline.advance({.counter = 0, .time_fine = 100'500}));
  EXPECT_EQ(timeline.lost_packets(), 0U);
  EXPECT_DOUBLE_EQ(timeline.time_s(), 10.05);
}

}  // namespace
}  // namespace soak::hal::imu::test
