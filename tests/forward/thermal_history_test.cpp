// SPDX-License-Identifier: Apache-2.0
#include "calib/forward/thermal_history.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace soak::calib::forward {
namespace {

/// A ramp of `slope` K/s from `first_c`, a point every ten seconds.
Series ramp(double first_c, double slope, int points) {
  Series series;
  for (int k = 0; k < points; ++k) {
    series.t_s.push_back(10.0 * k);
    series.values.push_back(first_c + slope * 10.0 * k);
  }
  return series;
}

TEST(ThermalHistory, AnElementFollowsARampByTauTimesTheSlope) {
  const Series element = follower_of(ramp(20.0, 0.02, 500), 200.0);
  // T(t) - Te(t) = slope tau (1 - exp(-t/tau)) behind a ramp that begins at rest.
  for (const double t_s : {0.0, 200.0, 1000.0, 4000.0}) {
    const double behind = 0.02 * 200.0 * (1.0 - std::exp(-t_s / 200.0));
    EXPECT_NEAR(element.at(t_s), 20.0 + 0.02 * t_s - behind, 1e-9) << t_s;
  }
}

TEST(ThermalHistory, AnElementFollowsAStepExponentially) {
  Series step = ramp(10.0, 0.0, 400);
  for (std::size_t k = 1; k < step.values.size(); ++k) step.values[k] = 30.0;
  const Series element = follower_of(step, 300.0);
  EXPECT_NEAR((30.0 - element.at(910.0)) / (30.0 - element.at(610.0)), std::exp(-1.0), 1e-9);
}

TEST(ThermalHistory, TheRateOfARampIsItsSlopeAndThatOfASettlingIsItsDerivative) {
  EXPECT_NEAR(rate_of(ramp(-5.0, -0.01, 300)).at(1500.0), -0.01, 1e-12);
  Series settling;
  for (int k = 0; k < 400; ++k) {
    settling.t_s.push_back(10.0 * k);
    settling.values.push_back(40.0 * std::exp(-10.0 * k / 900.0));
  }
  // A line through four minutes of an exponential of fifteen has its slope in the middle to (h/tau)^2/10.
  EXPECT_NEAR(rate_of(settling).at(1800.0), -40.0 / 900.0 * std::exp(-2.0), 5e-5);
}

TEST(ThermalHistory, TheBranchIsForgottenOverItsWidth) {
  // From cold (memory -1): after a way of w upwards the distance to +1 has shrunk by e.
  const Series warming = ramp(-40.0, 0.02, 600);
  const Series memory = branch_memory_of(warming, 10.0);
  EXPECT_DOUBLE_EQ(memory.values.front(), -1.0);
  // The dead band takes a quarter of a kelvin off the way.
  EXPECT_NEAR(memory.at((10.0 + 0.25) / 0.02), 1.0 - 2.0 * std::exp(-1.0), 1e-3);
  EXPECT_NEAR(memory.values.back(), 1.0, 1e-3);
}

TEST(ThermalHistory, DitheringBelowHalfAKelvinIsNoTurn) {
  Series dither = ramp(-40.0, 0.02, 600);
  const double reached = branch_memory_of(dither, 10.0).values.back();
  for (int k = 0; k < 100; ++k) {
    dither.t_s.push_back(dither.t_s.back() + 10.0);
    dither.values.push_back(dither.values[599] - (k % 2 == 0 ? 0.4 : 0.0));
  }
  EXPECT_DOUBLE_EQ(branch_memory_of(dither, 10.0).values.back(), reached);
}

TEST(ThermalHistory, ChannelsLoseTheirHolesAndMeansTheirEnds) {
  gap::RunLog log;
  log.t_s = {0.0, 10.0, 20.0, 30.0};
  const Series series = series_of(log, {1.0, std::numeric_limits<double>::quiet_NaN(), 3.0, 8.0});
  ASSERT_EQ(series.t_s.size(), 3U);
  EXPECT_DOUBLE_EQ(series.at(10.0), 2.0);
  EXPECT_DOUBLE_EQ(series.at(-5.0), 1.0);
  EXPECT_DOUBLE_EQ(series.at(99.0), 8.0);
  EXPECT_DOUBLE_EQ(series.mean(15.0, 35.0), 5.5);
  EXPECT_DOUBLE_EQ(series.mean(21.0, 29.0), series.at(25.0));
  EXPECT_TRUE(series_of(log, {}).empty());
}

}  // namespace
}  // namespace soak::calib::forward
