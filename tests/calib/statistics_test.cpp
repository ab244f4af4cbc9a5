// SPDX-License-Identifier: Apache-2.0
#include "calib/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "base/random.h"
#include "calib/signal/mean_error.h"
#include "calib/signal/noise.h"

namespace soak::calib {
namespace {

TEST(Describe, KeepsTheDigitsOfSmallScatterOnALargeMean) {
  std::vector<double> samples;
  for (int i = 0; i < 1000; ++i) samples.push_back(1e6 + (i % 2 == 0 ? 1e-4 : -1e-4));
  const SensorStatistics s = describe(samples);
  EXPECT_NEAR(s.mean, 1e6, 1e-9);
  EXPECT_NEAR(s.variance, 1e-8 * 1000 / 999, 1e-11);
}

TEST(Describe, PassesOverMissingSamples) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SensorStatistics s = describe(std::vector<double>{nan, 1.0, nan, 2.0, 3.0});
  EXPECT_EQ(s.count, 3U);
  EXPECT_DOUBLE_EQ(s.mean, 2.0);
  EXPECT_EQ(describe(std::vector<double>{nan}).count, 0U);
}

/// Root mean square of (mean of a series)/(its stated standard error) over many seeds: 1 where the statement is honest.
double honesty(double correlation, std::size_t length, int seeds) {
  double squares = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    base::Random random(static_cast<std::uint64_t>(seed), 7);
    std::vector<double> series(length);
    double state = random.gaussian() / std::sqrt(1.0 - correlation * correlation);
    for (double& v : series) {
      state = correlation * state + random.gaussian();
      v = state;
    }
    const SensorStatistics s = describe(series);
    squares += s.mean * s.mean / (s.standard_error * s.standard_error);
  }
  return std::sqrt(squares / seeds);
}

TEST(Describe, StandardErrorOfWhiteNoiseIsHonest) { EXPECT_NEAR(honesty(0.0, 600, 400), 1.0, 0.12); }

TEST(Describe, StandardErrorRespectsCorrelation) {
  // For a first-order process with correlation 0.9 the white-noise formula would be wrong by sqrt(19) = 4.4.
  const double ratio = honesty(0.9, 2000, 400);
  EXPECT_GT(ratio, 0.85);
  EXPECT_LT(ratio, 1.35);
}

TEST(Describe, GroupingLongStretchesDoesNotHideCorrelation) { EXPECT_LT(honesty(0.99, 20000, 100), 1.4); }

TEST(Describe, TakesTheStandardErrorThatDoesNotAverageDown) {
  // Flicker noise: the standard error of independent samples would be some twenty times too small.
  std::vector<double> samples = signal::flicker_noise(6000, 1.0, {1.0, 1});
  const double expected = signal::standard_error_of_mean(samples).standard_error;
  EXPECT_GT(expected, 0.3);
  samples.insert(samples.begin() + 100, std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(describe(samples).standard_error, expected);
}

TEST(FitLine, RecoversAStraightLineExactly) {
  const Line line = fit_line(std::vector<double>{1, 2, 4}, std::vector<double>{5, 7, 11});
  EXPECT_DOUBLE_EQ(line.slope, 2.0);
  EXPECT_DOUBLE_EQ(line.mean_y - line.slope * line.mean_x, 3.0);
}

}  // namespace
}  // namespace soak::calib
