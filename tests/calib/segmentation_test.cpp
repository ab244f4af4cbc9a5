// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/segmentation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"

namespace soak::calib {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Builds a recording row by row at 1 Hz.
struct Builder {
  Recording r;
  double t_s = 0.0;
  base::Random random{3};

  Builder() {
    r.run_id = "run";
    r.unit = "U";
    for (const auto label : kSixPositionLabels) r.positions.push_back(*position_named(label));
  }
  void rows(int count, double temp_c, double plateau_c, int position, Phase phase = Phase::soak) {
    for (int i = 0; i < count; ++i) row(temp_c + 0.01 * random.gaussian(), plateau_c, position, phase);
  }
  void ramp(double from_c, double to_c, double rate_kpmin) {
    const int count = static_cast<int>(std::abs(to_c - from_c) / rate_kpmin * 60.0);
    for (int i = 0; i < count; ++i) row(from_c + (to_c - from_c) * i / count, kNone, -1, Phase::ramp);
  }
  void row(double temp_c, double plateau_c, int position, Phase phase) {
    r.t_s.push_back(t_s);
    t_s += 1.0;
    r.temp_c.push_back(temp_c);
    r.plateau_c.push_back(plateau_c);
    r.position.push_back(position);
    r.phase.push_back(phase);
    r.sensor[0].push_back(random.gaussian());
  }
};

TEST(Segmentation, CutsByPlateauAndPositionAndLeavesRampsOut) {
  Builder b;
  b.rows(100, 0.0, 0.0, 0);
  b.rows(5, 0.0, 0.0, -1);
  b.rows(100, 0.0, 0.0, 1);
  b.ramp(0.0, 10.0, 5.0);
  b.rows(150, 10.0, 10.0, 1);
  const auto result = segment(b.r);
  ASSERT_TRUE(result);
  ASSERT_EQ(result->segments.size(), 3U);
  EXPECT_EQ(result->segments[0].key.position, "+X");
  EXPECT_EQ(result->segments[1].key.position, "-X");
  EXPECT_EQ(result->segments[1].key.visit, 0);
  EXPECT_EQ(result->segments[2].key.visit, 1);
  EXPECT_EQ(result->segments[2].sweep, Sweep::up);
  EXPECT_EQ(result->segments[0].sweep, Sweep::unknown);
  EXPECT_EQ(result->segments[0].sensor[0].count, 100U);
  EXPECT_NEAR(result->segments[2].temp_c, 10.0, 0.01);
  EXPECT_TRUE(result->warnings.empty());
}

TEST(Segmentation, CountsARevisitOfAPositionAsANewAttempt) {
  Builder b;
  b.rows(60, 0.0, 0.0, 0);
  b.rows(60, 0.0, 0.0, 1);
  b.rows(60, 0.0, 0.0, 0);
  const auto result = segment(b.r);
  ASSERT_EQ(result->segments.size(), 3U);
  EXPECT_EQ(result->segments[0].key.attempt, 0);
  EXPECT_EQ(result->segments[2].key.attempt, 1);
}

TEST(Segmentation, TakesADipBackToTheSameSetPointAsANewVisit) {
  Builder b;
  b.rows(60, 20.0, 20.0, 0);
  b.ramp(20.0, 15.0, 5.0);
  b.ramp(15.0, 20.0, 5.0);
  b.rows(60, 20.0, 20.0, 0);
  const auto result = segment(b.r);
  ASSERT_EQ(result->segments.size(), 2U);
  EXPECT_EQ(result->segments[1].key.visit, 1);
  EXPECT_EQ(result->segments[1].key.attempt, 0);
}

TEST(Segmentation, EndsASegmentAtAGapInTime) {
  Builder b;
  b.rows(60, 20.0, 20.0, 0);
  b.t_s += 100.0;
  b.rows(60, 20.0, 20.0, 0);
  EXPECT_EQ(segment(b.r)->segments.size(), 2U);
}

TEST(Segmentation, TurningPlateauKeepsItsArrivalDirection) {
  Builder b;
  for (const double level : {0.0, 10.0, 20.0, 10.0, 0.0}) b.rows(60, level, level, 0);
  const auto result = segment(b.r);
  ASSERT_EQ(result->segments.size(), 5U);
  EXPECT_EQ(result->segments[2].sweep, Sweep::up);
  EXPECT_EQ(result->segments[3].sweep, Sweep::down);
}

TEST(Segmentation, FindsPlateausFromTheTemperatureWhereNoneAreGiven) {
  Builder b;
  for (const double level : {-30.0, -20.0, -10.0, -20.0}) {
    b.rows(600, level, kNone, 4);
    b.ramp(level, level > -15.0 ? level - 10.0 : level + 10.0, 2.0);
  }
  b.r.phase.clear();  // the file says nothing of phases
  b.r.position.assign(b.r.rows(), 4);
  const auto result = segment(b.r);
  ASSERT_EQ(result->segments.size(), 4U);
  EXPECT_NEAR(*result->segments[0].plateau_c, -30.0, 0.11);
  EXPECT_NEAR(*result->segments[2].plateau_c, -10.0, 0.11);
  EXPECT_EQ(result->segments[2].sweep, Sweep::up);
  EXPECT_EQ(result->segments[3].sweep, Sweep::down);
  EXPECT_EQ(result->segments[0].blocks.size(), 10U);
}

TEST(Segmentation, WithoutPlateausThirtySecondBlocksStandIn) {
  Builder b;
  b.ramp(50.0, -10.0, 2.5);
  b.r.phase.clear();
  b.r.position.clear();
  const auto result = segment(b.r);
  ASSERT_EQ(result->segments.size(), 1U);
  EXPECT_FALSE(result->segments[0].plateau_c);
  EXPECT_EQ(result->segments[0].blocks.size(), 48U);  // 60 K at 2.5 K/min = 24 min
  EXPECT_NEAR(result->segments[0].blocks[3].temp_rate_kpmin, -2.5, 1e-6);
  EXPECT_FALSE(result->warnings.empty());
}

TEST(Segmentation, ASensorsOwnThermometerWinsInSegmentsAndBlocks) {
  Builder b;
  b.rows(120, 20.0, 20.0, 0);
  b.r.sensor_temp_c[0].assign(b.r.rows(), 31.5);
  const auto result = segment(b.r);
  EXPECT_NEAR(result->segments[0].sensor_temp_c[0], 31.5, 1e-9);
  EXPECT_NEAR(result->segments[0].sensor_temp_c[1], 20.0, 0.01);
  EXPECT_NEAR(result->segments[0].blocks[1].sensor_temp_c[0], 31.5, 1e-9);
}

TEST(Segmentation, LeavesOutSamplesWhoseTemperatureIsUnknown) {
  Builder b;
  b.rows(100, 20.0, 20.0, 0);
  for (std::size_t i = 0; i < 40; ++i) {
    b.r.temp_c[i] = kNone;
    b.r.sensor[0][i] = 1000.0;
  }
  const auto result = segment(b.r);
  EXPECT_EQ(result->segments[0].sensor[0].count, 60U);
  EXPECT_LT(result->segments[0].sensor[0].mean, 1.0);
}

TEST(Segmentation, RefusesAnEmptyRecording) { EXPECT_FALSE(segment(Recording{})); }

TEST(Plateaus, ASlowRampIsNoPlateau) {
  std::vector<double> t;
  std::vector<double> temp;
  for (int i = 0; i < 7200; ++i) {
    t.push_back(i);
    temp.push_back(i * 0.1 / 60.0 * 10.0);  // 1 K/min
  }
  EXPECT_TRUE(find_plateaus(t, temp).empty());
  for (double& v : temp) v *= 0.15;  // 0.15 K/min: each stretch of 180 s is still within the band
  EXPECT_TRUE(find_plateaus(t, temp).empty());
}

TEST(Plateaus, ASettlingTailBelongsToItsPlateau) {
  std::vector<double> t;
  std::vector<double> temp;
  for (int i = 0; i < 3600; ++i) {
    t.push_back(i);
    temp.push_back(20.0 - 10.0 * std::exp(-i / 300.0));
  }
  const auto found = find_plateaus(t, temp);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].last, 3600U);
  EXPECT_NEAR(found[0].temp_c, 20.0, 0.3);
}

}  // namespace
}  // namespace soak::calib
