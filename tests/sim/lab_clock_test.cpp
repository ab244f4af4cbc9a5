// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/device_time.h"

#include <gtest/gtest.h>

namespace soak::hal::sim {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kMillisecond_ns = 1'000'000;

TEST(LabClock, GoesAtItsRate) {
  LabClock clock(10.0);
  Tick now = clock.allowed(5 * kSecond_ns, 0);
  EXPECT_EQ(now, 0);
  for (int i = 1; i <= 100; ++i) now = clock.allowed(5 * kSecond_ns + i * 50 * kMillisecond_ns, now);
  EXPECT_EQ(now, 5 * 10 * kTicksPerSecond);
}

TEST(LabClock, TellsWhenATickIsDue) {
  LabClock clock(2.0);
  (void)clock.allowed(0, 0);
  EXPECT_EQ(clock.ns_until(kTicksPerSecond, 0), kSecond_ns / 2);
  EXPECT_EQ(clock.ns_until(kTicksPerSecond, kSecond_ns), 0);
  EXPECT_GE(clock.allowed(clock.ns_until(40, 0), 0), 40);
}

TEST(LabClock, DoesNotMakeUpForTimeInWhichItWasHeld) {
  LabClock clock(1.0);
  (void)clock.allowed(0, 0);
  clock.hold(60 * kSecond_ns, 400);
  EXPECT_EQ(clock.allowed(60 * kSecond_ns, 400), 400);
  EXPECT_EQ(clock.allowed(61 * kSecond_ns, 760), 800);
}

TEST(LabClock, MakesUpForATenthOfASecondAtMost) {
  LabClock clock(1.0);
  (void)clock.allowed(0, 0);
  EXPECT_EQ(clock.allowed(10 * kSecond_ns, 0), kTicksPerSecond / 10);
}

}  // namespace
}  // namespace soak::hal::sim
