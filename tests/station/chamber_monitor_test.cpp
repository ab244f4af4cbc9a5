// SPDX-License-Identifier: Apache-2.0
#include "station/lab/device_monitors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace soak::station {
namespace {

/// A chamber that says what it is told to say, or does not answer.
class FakeChamber final : public hal::Chamber {
 public:
  base::Status connect() override { return {}; }
  base::Result<hal::ChamberReading> read() override {
    ++reads;
    if (!answers) return base::fail(base::ErrorKind::device, "no answer");
    return says;
  }
  base::Status set_temperature(double) override { return {}; }
  base::Status set_ramp_rate(std::optional<double>) override { return {}; }
  base::Status start() override { return {}; }
  base::Status stop() override { return {}; }
  [[nodiscard]] std::optional<double> min_set_point_c() const override { return {}; }
  [[nodiscard]] std::optional<double> max_set_point_c() const override { return {}; }
  [[nodiscard]] bool can_ramp() const override { return false; }
  [[nodiscard]] std::string description() const override { return "fake"; }

  bool answers = true;
  hal::ChamberReading says;
  int reads = 0;
};

class ChamberMonitorTest : public ::testing::Test {
 protected:
  void SetUp() override {
    chamber.says.air_c = 20.0;
    chamber.says.set_point_c = -30.0;
    chamber.says.running = true;
  }

  /// One look at the chamber, ten seconds of process time after the last one.
  bool look() {
    now_s += 10.0;
    const int before = chamber.reads;
    // Looks follow each other by 2 ms of host time at least.
    for (;;) {
      const bool fresh = monitor.poll(now_s);
      if (chamber.reads != before) return fresh;
      std::this_thread::yield();
    }
  }

  /// A look for which the interval need not pass: the next one comes at once.
  bool look_at_once() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{10};
    const int before = chamber.reads;
    while (std::chrono::steady_clock::now() < deadline) {
      const bool fresh = monitor.poll(now_s);
      if (chamber.reads != before) return fresh;
    }
    return false;
  }

  void look(int times) {
    for (int i = 0; i < times; ++i) look();
  }

  FakeChamber chamber;
  ChamberMonitor monitor{chamber, 10.0};
  double now_s = 0.0;
};

TEST_F(ChamberMonitorTest, KnowsNothingBeforeItsFirstReading) {
  EXPECT_TRUE(monitor.stale());
  EXPECT_FALSE(monitor.age_s());
  EXPECT_TRUE(look());
  EXPECT_FALSE(monitor.stale());
  EXPECT_EQ(monitor.reading()->air_c, 20.0);
  ASSERT_TRUE(monitor.age_s());
  EXPECT_GE(*monitor.age_s(), 0.0);
}

TEST_F(ChamberMonitorTest, ReadsOncePerIntervalOfProcessTime) {
  look();
  const int before = chamber.reads;
  const auto past_the_pause = std::chrono::steady_clock::now() + std::chrono::milliseconds{5};
  while (std::chrono::steady_clock::now() < past_the_pause) EXPECT_FALSE(monitor.poll(now_s + 9.9));
  EXPECT_EQ(chamber.reads, before);
  look();
  EXPECT_EQ(chamber.reads, before + 1);
}

TEST_F(ChamberMonitorTest, AFastClockDoesNotLetItReadWithoutPause) {
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 20'000; ++i) static_cast<void>(monitor.poll(100.0 * i));
  const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(chamber.reads, 1.0 + passed.count() / 2.0);
}

TEST_F(ChamberMonitorTest, ThreeFailedReadsInARowMakeItStale) {
  look();
  chamber.answers = false;
  for (int miss = 1; miss <= 3; ++miss) {
    EXPECT_FALSE(look());
    EXPECT_EQ(monitor.stale(), miss == 3) << miss;
    EXPECT_EQ(monitor.trouble(), "no answer");
  }
  chamber.answers = true;
  EXPECT_TRUE(look());
  EXPECT_FALSE(monitor.stale());
  EXPECT_EQ(monitor.trouble(), "");
}

TEST_F(ChamberMonitorTest, FailuresBetweenAnswersDoNotAddUp) {
  for (int i = 0; i < 5; ++i) {
    chamber.answers = true;
    look();
    chamber.answers = false;
    look(2);
    EXPECT_FALSE(monitor.stale());
  }
}

TEST_F(ChamberMonitorTest, ForgetsTheReadingAndReadsAtTheNextPoll) {
  look();
  monitor.forget();
  EXPECT_TRUE(monitor.stale());
  EXPECT_TRUE(monitor.poll(now_s)) << "the interval has not passed";
  EXPECT_FALSE(monitor.stale());
}

TEST_F(ChamberMonitorTest, ThreeReadingsWithAnotherSetPointAreDisobedience) {
  monitor.expect(-30.0);
  look(5);
  EXPECT_FALSE(monitor.lost_set_point());
  chamber.says.set_point_c = 25.0;
  for (int i = 1; i <= 3; ++i) {
    look();
    EXPECT_EQ(monitor.lost_set_point(), i == 3) << i;
  }
  chamber.says.set_point_c = -30.0;
  look();
  EXPECT_FALSE(monitor.lost_set_point());
}

TEST_F(ChamberMonitorTest, ASetPointThatIsRoundedIsObeyed) {
  monitor.expect(-30.0);
  chamber.says.set_point_c = -29.6;
  look(5);
  EXPECT_FALSE(monitor.lost_set_point());
  chamber.says.set_point_c = -29.4;
  look(3);
  EXPECT_TRUE(monitor.lost_set_point());
}

TEST_F(ChamberMonitorTest, ControlThatIsOffIsDisobedience) {
  monitor.expect(-30.0);
  chamber.says.running = false;
  look(2);
  EXPECT_FALSE(monitor.lost_set_point());
  look();
  EXPECT_TRUE(monitor.lost_set_point());
}

TEST_F(ChamberMonitorTest, FailedReadsAreNoReadings) {
  monitor.expect(-30.0);
  chamber.says.running = false;
  look(2);
  chamber.answers = false;
  look(5);
  EXPECT_FALSE(monitor.lost_set_point());
}

TEST_F(ChamberMonitorTest, AnExpectationBeginsTheCountAnew) {
  monitor.expect(-30.0);
  chamber.says.set_point_c = 25.0;
  look(3);
  EXPECT_TRUE(monitor.lost_set_point());
  monitor.expect(40.0);
  EXPECT_FALSE(monitor.lost_set_point());
  EXPECT_EQ(monitor.expected_c(), 40.0);
  look(2);
  EXPECT_FALSE(monitor.lost_set_point());
  look();
  EXPECT_TRUE(monitor.lost_set_point());
}

TEST_F(ChamberMonitorTest, WithoutExpectationItMayDoAsItLikes) {
  chamber.says.running = false;
  look(10);
  EXPECT_FALSE(monitor.lost_set_point());
  monitor.expect(-30.0);
  monitor.expect(std::nullopt);
  look(10);
  EXPECT_FALSE(monitor.lost_set_point());
}

TEST_F(ChamberMonitorTest, TheAirStandsStillByProcessTime) {
  calib::StabilityCriterion criterion;
  criterion.slope_kpmin = 0.1;
  monitor.judge_air(criterion);
  // 0.6 K/min first, then none: ripple of two hundredths in either.
  for (int i = 0; i < 40; ++i) {
    chamber.says.air_c = 20.0 + 0.1 * i + 0.02 * (i % 2);
    look();
    EXPECT_FALSE(monitor.air_is_stable());
  }
  for (int i = 0; i < 40; ++i) {
    chamber.says.air_c = 24.0 + 0.02 * (i % 2);
    look();
  }
  EXPECT_TRUE(monitor.air_is_stable());
}

TEST_F(ChamberMonitorTest, AnAlarmCountsOnceTwoReadingsInARowHaveIt) {
  look();
  chamber.says.alarms = {{"alarm 1", true}};
  look();
  EXPECT_TRUE(monitor.alarms().empty());
  const int before = chamber.reads;
  while (chamber.reads == before) static_cast<void>(monitor.poll(now_s));  // at once: the interval has not passed
  EXPECT_EQ(monitor.alarms(), chamber.says.alarms);
  chamber.says.alarms.clear();
  look();
  EXPECT_TRUE(monitor.alarms().empty());
  for (int i = 0; i < 6; ++i) {
    chamber.says.alarms =
        i % 2 == 0 ? std::vector<hal::ChamberAlarm>{{"alarm 1", true}} : std::vector<hal::ChamberAlarm>{};
    look();
    EXPECT_TRUE(monitor.alarms().empty()) << i;
  }
}

TEST_F(ChamberMonitorTest, AReadingFartherThanAnyChamberGetsIsReadAgainAtOnceBeforeItCounts) {
  look();
  chamber.says.air_c = -29.5;  // a flipped bit: the set point, as it seems
  const int before = chamber.reads;
  EXPECT_FALSE(look());
  EXPECT_EQ(monitor.reading()->air_c, 20.0);
  chamber.says.air_c = 19.9;
  EXPECT_TRUE(look_at_once()) << "the interval has not passed";
  EXPECT_EQ(chamber.reads, before + 2);
  EXPECT_EQ(monitor.reading()->air_c, 19.9);
}

TEST_F(ChamberMonitorTest, AJumpThatASecondReadingConfirmsCounts) {
  look();
  chamber.says.air_c = 80.0;
  EXPECT_FALSE(look());
  chamber.says.air_c = 81.0;
  EXPECT_TRUE(look_at_once());
  EXPECT_EQ(monitor.reading()->air_c, 81.0);
}

TEST_F(ChamberMonitorTest, WhatAChamberCanDoSinceTheLastReadingIsNoJump) {
  look();
  chamber.says.air_c = 28.0;  // 8 K in 10 s at 20 K/min and 5 K of noise
  EXPECT_TRUE(look());
  now_s += 600.0;
  chamber.says.air_c = -60.0;
  EXPECT_TRUE(look()) << "ten minutes later";
}

TEST_F(ChamberMonitorTest, ReadingsThatJumpAboutAreNone) {
  look();
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(monitor.stale()) << i;
    chamber.says.air_c = 100.0 + 60.0 * i;
    EXPECT_FALSE(i == 0 ? look() : look_at_once());
  }
  EXPECT_TRUE(monitor.stale());
  EXPECT_NE(monitor.trouble(), "");
}

TEST_F(ChamberMonitorTest, AnAlarmBesideAJumpStillCounts) {
  look();
  chamber.says.air_c = 120.0;
  chamber.says.alarms = {{"alarm 1", true}};
  EXPECT_FALSE(look());
  EXPECT_TRUE(look_at_once());
  EXPECT_EQ(monitor.alarms(), chamber.says.alarms);
}

}  // namespace
}  // namespace soak::station
