// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/samples/sample_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/random.h"

namespace soak::calib::signal {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<double> times(std::size_t count, double step_s) {
  std::vector<double> t;
  for (std::size_t i = 0; i < count; ++i) t.push_back(static_cast<double>(i) * step_s);
  return t;
}

TEST(SampleGrid, EvenTimesStayAsTheyAre) {
  const std::vector<double> values = {1, 2, 3, 4, 5};
  const auto grid = equally_spaced(times(5, 0.01), values);
  ASSERT_TRUE(grid);
  EXPECT_NEAR(grid->rate_hz, 100.0, 1e-9);
  EXPECT_EQ(grid->values, values);
}

TEST(SampleGrid, LackingRowsComeInAsMissing) {
  const auto grid = equally_spaced(std::vector<double>{0, 1, 2, 5, 6}, std::vector<double>{1, 1, 1, 2, 2});
  ASSERT_TRUE(grid);
  ASSERT_EQ(grid->values.size(), 7U);
  EXPECT_TRUE(std::isnan(grid->values[3]) && std::isnan(grid->values[4]));
  EXPECT_EQ(grid->values[5], 2.0);
  EXPECT_EQ(grid->t_s[4], 4.0);
}

TEST(SampleGrid, ASlowChannelComesOutAtItsOwnRate) {
  std::vector<double> values(1000, kNan);
  for (std::size_t i = 0; i < values.size(); i += 10) values[i] = 1.0;
  const auto grid = equally_spaced(times(1000, 0.001), values);
  ASSERT_TRUE(grid);
  EXPECT_NEAR(grid->rate_hz, 100.0, 1e-6);
  EXPECT_EQ(grid->values.size(), 100U);
}

TEST(SampleGrid, TimesThatWerePrintedCoarselyLeaveNoFalseGaps) {
  // 300 Hz printed to the millisecond: distances of 3 and 4 ms.
  std::vector<double> t = times(3000, 1.0 / 300.0);
  for (double& v : t) v = std::round(v * 1000.0) / 1000.0;
  const auto grid = equally_spaced(t, std::vector<double>(3000, 1.0));
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->values.size(), 3000U);
  EXPECT_NEAR(grid->rate_hz, 300.0, 0.05);
}

/// `count` samples at 200 Hz whose times scatter uniformly by up to `share` of a step, some of them lost.
struct Arrivals {
  std::vector<double> t_s;
  std::size_t lost = 0;

  Arrivals(std::size_t count, double share, double loss) {
    base::Random random(11);
    for (std::size_t i = 0; i < count; ++i) {
      const double t = 0.005 * (static_cast<double>(i) + share * random.uniform(-1.0, 1.0));
      const bool is_lost = i > 0 && i + 1 < count && random.uniform() < loss;
      if (is_lost) {
        ++lost;
      } else {
        t_s.push_back(t);
      }
    }
  }
};

TEST(SampleGrid, LostRowsAreCountedAndLeaveTheRateRight) {
  for (const double loss : {0.001, 0.02, 0.05, 0.2}) {
    const Arrivals arrivals(20000, 0.0, loss);
    const auto grid = equally_spaced(arrivals.t_s, std::vector<double>(arrivals.t_s.size(), 1.0));
    ASSERT_TRUE(grid);
    EXPECT_NEAR(grid->rate_hz, 200.0, 1e-6) << loss;
    EXPECT_EQ(grid->values.size(), 20000U) << loss;
  }
}

TEST(SampleGrid, JitterMakesNeitherGapsNorAnotherRate) {
  for (const double share : {0.1, 0.3, 0.4}) {
    const Arrivals arrivals(20000, share, 0.0);
    const auto grid = equally_spaced(arrivals.t_s, std::vector<double>(arrivals.t_s.size(), 1.0));
    ASSERT_TRUE(grid);
    // The ends of 20,000 steps are off by a step at most.
    EXPECT_NEAR(grid->rate_hz, 200.0, 200.0 * 2e-4) << share;
    EXPECT_EQ(grid->values.size(), 20000U) << share;
    EXPECT_NEAR(grid->scatter, share / std::sqrt(3.0), 0.1 * share) << share;
  }
}

TEST(SampleGrid, JitterAndLostRowsTogetherStayApart) {
  const Arrivals arrivals(20000, 0.2, 0.02);
  const auto grid = equally_spaced(arrivals.t_s, std::vector<double>(arrivals.t_s.size(), 1.0));
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->values.size(), 20000U);
}

TEST(SampleGrid, BurstsHaveTheirMeanRateAndNoGaps) {
  std::vector<double> t;
  for (int i = 0; i < 20000; ++i) t.push_back(0.020 * (i / 4) + 0.0005 * (i % 4));
  const auto grid = equally_spaced(t, std::vector<double>(t.size(), 1.0));
  ASSERT_TRUE(grid);
  EXPECT_NEAR(grid->rate_hz, 200.0, 0.1);
  EXPECT_EQ(grid->values.size(), t.size());
}

TEST(SampleGrid, ARateThatChangesIsRefusedWithBoth) {
  std::vector<double> t = {0.0};
  for (int i = 0; i < 10000; ++i) t.push_back(t.back() + (i < 5000 ? 0.005 : 0.010));
  const auto grid = equally_spaced(t, std::vector<double>(t.size(), 1.0));
  ASSERT_FALSE(grid);
  EXPECT_NE(grid.error().message.find("from 200 to 100 Hz"), std::string::npos) << grid.error().message;
}

TEST(SampleGrid, AClockThatRunsOffSlowlyLeavesNoFalseGaps) {
  // 199.9 Hz called 200, then drifting by 100 ppm over the record.
  std::vector<double> t = {0.0};
  for (int i = 0; i < 100000; ++i) t.push_back(t.back() + (1.0 + 1e-4 * i / 100000.0) / 199.9);
  const auto grid = equally_spaced(t, std::vector<double>(t.size(), 1.0));
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->values.size(), t.size());
}

TEST(SampleGrid, ABreakSeparatesStretchesThatFollowClosely) {
  const std::vector<std::size_t> breaks = {3};
  const auto grid = equally_spaced(times(6, 1.0), std::vector<double>{1, 1, 1, 9, 9, 9}, breaks);
  ASSERT_TRUE(grid);
  const auto ranges = stretches_of(grid->values);
  ASSERT_EQ(ranges.size(), 2U);
  EXPECT_EQ(ranges[0].count(), 3U);
  EXPECT_EQ(ranges[1].first - ranges[0].last, kBreak);
}

TEST(SampleGrid, RefusesWhatCannotBePlaced) {
  EXPECT_FALSE(equally_spaced(std::vector<double>{0, 1, 1}, std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(equally_spaced(std::vector<double>{0, 1}, std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(equally_spaced(std::vector<double>{0, 1}, std::vector<double>{1, kNan}));
  EXPECT_FALSE(equally_spaced(std::vector<double>{0, 1, 2, 1e12}, std::vector<double>{1, 2, 3, 4}));
}

TEST(ShortGaps, AreFilledByAStraightLineAndLongOnesStay) {
  std::vector<double> values = {kNan, 0, kNan, kNan, 3, kNan, kNan, kNan, 9, kNan};
  EXPECT_EQ(fill_short_gaps(values, 2), 2U);
  EXPECT_EQ(values[2], 1.0);
  EXPECT_EQ(values[3], 2.0);
  EXPECT_TRUE(std::isnan(values[0]) && std::isnan(values[6]) && std::isnan(values[9]));
}

TEST(StretchMeans, AreTakenOffEachStretch) {
  std::vector<double> values = {1, 3, kNan, 10, 20, 30};
  remove_stretch_means(values);
  EXPECT_EQ((std::vector<double>{values[0], values[1], values[3], values[4], values[5]}),
            (std::vector<double>{-1, 1, -10, 0, 10}));
}

}  // namespace
}  // namespace soak::calib::signal
