// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/control_chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "base/random.h"

namespace soak::calib {
namespace {

/// Values of a process in control: standard normal.
std::vector<double> steady(std::size_t count, std::uint64_t seed) {
  base::Random random(seed, 31);
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(random.gaussian());
  return values;
}

/// Ten values about 5 whose neighbours are 1 apart on average, none beyond the limits.
const std::vector<double> kTen = {5.0, 6.0, 5.0, 4.0, 5.0, 6.0, 5.0, 4.0, 5.0, 4.0};

std::vector<double> ten_and(const std::vector<double>& more) {
  std::vector<double> values = kTen;
  values.insert(values.end(), more.begin(), more.end());
  return values;
}

TEST(ControlChart, LimitOfTheMovingRangeIsThatOfTwoNormalValues) {
  // |X − Y| has the density exp(−r²/4)/√π, r > 0: its moments by the trapezoidal rule, whose error is far below 1e-6
  // for a density that is smooth and gone at the far end.
  double first = 0.0;
  double second = 0.0;
  constexpr double kStep = 1e-3;
  for (int i = 1; i < 20000; ++i) {
    const double r = kStep * i;
    const double density = std::exp(-r * r / 4.0) * std::numbers::inv_sqrtpi;
    first += kStep * r * density;
    second += kStep * r * r * density;
  }
  EXPECT_NEAR(kD4, 1.0 + 3.0 * std::sqrt(second - first * first) / first, 1e-6);
}

TEST(ControlChart, FlowRatesOfTheNistHandbookHaveTheirMeanAndMovingRange) {
  // NIST/SEMATECH e-Handbook of Statistical Methods, 6.3.2.2: flow rate of ten batches.
  const std::vector<double> flow = {49.6, 47.6, 49.9, 51.3, 47.8, 51.2, 52.6, 52.4, 53.6, 52.1};
  const auto limits = control_limits(flow, 1);
  ASSERT_TRUE(limits);
  EXPECT_EQ(limits->values, 10u);
  EXPECT_NEAR(limits->centre, 50.81, 1e-9);
  EXPECT_NEAR(limits->moving_range_upper, kD4 * 1.8778, kD4 * 5e-5);
}

TEST(ControlChart, LimitsAreThoseOfStudentsDistribution) {
  // Quantiles of t for 1/1200 in both tails, by another program (SciPy 1.10, stats.t.isf(1/2400, n - 1)).
  for (const auto& [n, t] : {std::pair{10U, 4.912355190}, std::pair{17U, 4.101840165}, std::pair{25U, 3.818081066}}) {
    std::vector<double> values;
    for (unsigned i = 0; i < n; ++i) values.push_back(i % 3);
    double mean = 0.0;
    double squares = 0.0;
    for (const double value : values) mean += value / n;
    for (const double value : values) squares += (value - mean) * (value - mean);
    const double sigma = std::sqrt(squares / (n - 1));
    for (const std::size_t of : {std::size_t{1}, kShiftValues}) {
      const ControlLimits limits = control_limits(values, of).value();
      EXPECT_NEAR(limits.sigma, sigma, 1e-12);
      EXPECT_NEAR(limits.upper - mean, t * sigma * std::sqrt(1.0 / static_cast<double>(of) + 1.0 / n), 1e-7);
      EXPECT_NEAR(mean - limits.lower, limits.upper - mean, 1e-12);
    }
  }
}

/// Share of means of `of` normal values beyond the limits that `before` normal values gave. The width of the limits in
/// standard deviations depends on the numbers alone; the rest is none of our code.
double beyond_share(std::size_t before, std::size_t of, int draws, std::mt19937_64& generator) {
  std::vector<double> any;
  for (std::size_t i = 0; i < before; ++i) any.push_back(static_cast<double>(i % 2));
  const ControlLimits limits = control_limits(any, of).value();
  const double width = (limits.upper - limits.centre) / limits.sigma;
  std::normal_distribution<double> normal;
  int beyond = 0;
  for (int draw = 0; draw < draws; ++draw) {
    double sum = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < before; ++i) {
      const double value = normal(generator);
      sum += value;
      squares += value * value;
    }
    const auto n = static_cast<double>(before);
    const double sigma = std::sqrt((squares - sum * sum / n) / (n - 1.0));
    double mean = 0.0;
    for (std::size_t i = 0; i < of; ++i) mean += normal(generator) / static_cast<double>(of);
    beyond += std::abs(mean - sum / n) > width * sigma ? 1 : 0;
  }
  return static_cast<double>(beyond) / draws;
}

TEST(ControlChart, OneTestFailsAsOftenAsStatedWhateverTheNumberOfEarlierValues) {
  std::mt19937_64 generator(20261122);
  constexpr int kDraws = 200000;
  // Four standard errors of a share.
  const double tolerance = 4.0 * std::sqrt(kFalseAlarmPerTest / kDraws);
  for (const std::size_t before : {10U, 13U, 18U, 25U}) {
    EXPECT_NEAR(beyond_share(before, 1, kDraws, generator), kFalseAlarmPerTest, tolerance) << before;
    EXPECT_NEAR(beyond_share(before, kShiftValues, kDraws, generator), kFalseAlarmPerTest, tolerance) << before;
  }
}

TEST(ControlChart, AlarmsOfCampaignsInWhichNothingChangedAreAtMostAsOftenAsStated) {
  // Stations in control with six independent sensors, the worst case, and 60 campaigns each.
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  constexpr std::size_t kStations = 600;
  constexpr std::size_t kCampaigns = 60;
  std::array<std::size_t, 3> alarms{};  // of campaigns 11 to 17, 18 to 25, later
  for (std::size_t station = 0; station < kStations; ++station) {
    std::array<bool, kCampaigns> alarm{};
    for (std::size_t sensor = 0; sensor < kSensorCount; ++sensor) {
      std::vector<double> values(kCampaigns);
      for (double& value : values) value = normal(generator);
      const auto chart = control_chart(values);
      for (std::size_t c = 0; c < kCampaigns; ++c) {
        alarm[c] = alarm[c] || chart[c].verdict == ControlVerdict::out_of_control;
      }
    }
    for (std::size_t c = 0; c < kCampaigns; ++c) alarms[c < 17 ? 0 : c < 25 ? 1 : 2] += alarm[c] ? 1 : 0;
  }
  const std::array<std::size_t, 3> judged = {7 * kStations, 8 * kStations, 35 * kStations};
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const auto count = static_cast<double>(judged[k]);
    const double share = static_cast<double>(alarms[k]) / count;
    // Alarms of one station come in rows of up to eight, as the means of eight overlap: their variance is up to eight
    // times that of independent ones. Three standard errors.
    EXPECT_LT(share, kFalseAlarmPerCampaign + 3.0 * std::sqrt(8.0 * kFalseAlarmPerCampaign / count)) << k;
    EXPECT_GT(share, 0.2 * kFalseAlarmPerCampaign) << k << ": limits so wide find nothing";
  }
}

TEST(ControlChart, FewerThanTenEarlierValuesJudgeNothing) {
  const auto chart = control_chart(ten_and({5.0}));
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(chart[i].verdict, ControlVerdict::not_established) << i;
    EXPECT_FALSE(chart[i].limits);
  }
  EXPECT_EQ(chart[10].verdict, ControlVerdict::in_control);
  EXPECT_EQ(control_chart({}).size(), 0u);
  // Not even what is plainly wrong: nobody knows how the process scatters.
  EXPECT_EQ(control_chart(std::vector{1.0, 2.0, 1e6}).back().verdict, ControlVerdict::not_established);
}

TEST(ControlChart, AValueIsJudgedByEarlierOnesAndNothingLaterChangesIt) {
  std::vector<double> values = steady(60, 5);
  values[40] = 25.0;
  const auto whole = control_chart(values);
  for (std::size_t count = 1; count <= values.size(); ++count) {
    const auto part = control_chart(std::span(values).first(count));
    ASSERT_EQ(part.size(), count);
    EXPECT_EQ(part.back().verdict, whole[count - 1].verdict);
    EXPECT_EQ(part.back().limits.has_value(), whole[count - 1].limits.has_value());
    if (part.back().limits) {
      EXPECT_EQ(part.back().limits->upper, whole[count - 1].limits->upper);
    }
  }
}

TEST(ControlChart, AValueBeyondTheLimitsIsOutAndLeavesThemAsTheyWere) {
  const ControlLimits limits = control_limits(kTen, 1).value();
  // Both sides of the limit, a thousandth of sigma apart.
  const double step = 1e-3 * limits.sigma;
  EXPECT_EQ(control_chart(ten_and({limits.upper - step})).back().verdict, ControlVerdict::in_control);
  EXPECT_EQ(control_chart(ten_and({limits.lower + step})).back().verdict, ControlVerdict::in_control);
  EXPECT_TRUE(control_chart(ten_and({limits.lower - step})).back().beyond_limits());
  const auto chart = control_chart(ten_and({limits.upper + step, 5.0}));
  EXPECT_TRUE(chart[10].beyond_limits());
  EXPECT_FALSE(chart[10].shifted());
  EXPECT_EQ(chart[10].verdict, ControlVerdict::out_of_control);
  EXPECT_EQ(chart[11].verdict, ControlVerdict::in_control);
  EXPECT_EQ(chart[11].limits->values, 10u);
  EXPECT_EQ(chart[11].limits->upper, limits.upper);
}

TEST(ControlChart, AShiftWithinTheLimitsIsFoundByTheMeanOfTheLastEight) {
  // Ten values, seven more that scatter alike, then a level 3 sigma up: no value of it is beyond its own limits.
  std::vector<double> values = ten_and({5.0, 6.0, 5.0, 4.0, 5.0, 6.0, 4.0});
  values.insert(values.end(), 8, 7.2);
  const auto chart = control_chart(values);
  EXPECT_FALSE(chart[16].shift) << "nine values before the last eight";
  ASSERT_TRUE(chart[17].shift);
  EXPECT_EQ(chart[17].shift->limits.values, 10u);
  EXPECT_NEAR(chart[17].shift->mean, (5.0 + 6.0 + 5.0 + 4.0 + 5.0 + 6.0 + 4.0 + 7.2) / 8.0, 1e-12);
  EXPECT_EQ(chart[17].verdict, ControlVerdict::in_control);
  const ControlPoint& last = chart.back();
  EXPECT_FALSE(last.beyond_limits());
  EXPECT_TRUE(last.shifted());
  EXPECT_EQ(last.verdict, ControlVerdict::out_of_control);
  EXPECT_NEAR(last.shift->mean, 7.2, 1e-12);
  EXPECT_EQ(last.shift->limits.upper, control_limits(std::span(values).first(17), 8)->upper);
}

TEST(ControlChart, AValueBeyondItsLimitsIsNoneOfTheLastEight) {
  std::vector<double> values = steady(40, 3);
  for (double& value : values) value = std::clamp(value, -1.0, 1.0);
  values[30] = 1000.0;
  const auto chart = control_chart(values);
  EXPECT_TRUE(chart[30].beyond_limits());
  EXPECT_FALSE(chart[30].shift);
  for (std::size_t i = 31; i < values.size(); ++i) {
    EXPECT_EQ(chart[i].verdict, ControlVerdict::in_control) << i;
    EXPECT_LE(std::abs(chart[i].shift.value().mean), 1.0) << i;
  }
}

TEST(ControlChart, LimitsStandStillFromTwentyFiveValuesOnSoThatADriftShows) {
  std::vector<double> values = steady(80, 9);
  for (std::size_t i = 30; i < values.size(); ++i) values[i] += 0.1 * static_cast<double>(i - 30);
  const auto chart = control_chart(values);
  std::size_t most = 0;
  for (const ControlPoint& point : chart) most = std::max(most, point.limits ? point.limits->values : 0);
  EXPECT_EQ(most, 25u);
  // After 50 values the drift is 5 sigma.
  EXPECT_EQ(chart.back().verdict, ControlVerdict::out_of_control);
  EXPECT_EQ(chart.back().limits->upper, chart[45].limits->upper);
}

TEST(ControlChart, ValuesWithoutScatterMakeNoLimits) {
  EXPECT_FALSE(control_limits(std::vector<double>(20, 3.0), 1));
  EXPECT_EQ(control_chart(std::vector<double>(20, 3.0)).back().verdict, ControlVerdict::not_established);
}

TEST(ControlChart, MovingRangesAreThoseOfNeighboursAndHaveTheirLimit) {
  const auto chart = control_chart(ten_and({7.5}));
  EXPECT_FALSE(chart[0].moving_range);
  EXPECT_EQ(chart[1].moving_range, 1.0);
  EXPECT_EQ(chart[10].moving_range, 3.5);
  EXPECT_NEAR(chart[10].limits->moving_range_upper, kD4, 1e-12);  // the mean moving range is 1
}

}  // namespace
}  // namespace soak::calib
