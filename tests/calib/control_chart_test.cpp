// SPDX-License-Identifier: Apache-2.0
#include "calib/control_chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
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

TEST(ControlChart, ConstantsAreThoseOfTheRangeOfTwoNormalValues) {
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
  EXPECT_NEAR(kD2, first, 1e-6);
  EXPECT_NEAR(kD4, 1.0 + 3.0 * std::sqrt(second - first * first) / first, 1e-6);
}

TEST(ControlChart, FlowRatesOfTheNistHandbookHaveItsLimits) {
  // NIST/SEMATECH e-Handbook of Statistical Methods, 6.3.2.2: flow rate of ten batches.
  const std::vector<double> flow = {49.6, 47.6, 49.9, 51.3, 47.8, 51.2, 52.6, 52.4, 53.6, 52.1};
  const auto limits = control_limits(flow);
  ASSERT_TRUE(limits);
  EXPECT_EQ(limits->values, 10u);
  EXPECT_NEAR(limits->centre, 50.81, 1e-9);
  EXPECT_NEAR(limits->mean_moving_range, 1.8778, 5e-5);
  // The handbook takes d2 = 1.128, in three decimals; printed to four.
  const double half = (limits->upper - limits->centre) * kD2 / 1.128;
  EXPECT_NEAR(limits->centre + half, 55.8041, 5e-5);
  EXPECT_NEAR(limits->centre - half, 45.8159, 5e-5);
  EXPECT_NEAR(limits->upper - limits->centre, limits->centre - limits->lower, 1e-12);
  // "The process is in control, since none of the plotted points fall outside."
  for (std::size_t i = 1; i <= flow.size(); ++i) {
    EXPECT_FALSE(judge(*limits, std::span(flow).first(i)).beyond_limits) << flow[i - 1];
  }
}

TEST(ControlChart, RunLengthWithKnownLimitsIsThatOfItsMarkovChain) {
  // After k values in a row on one side, with chance p of a value within the limits on a given side,
  // L_k = 1 + p L_{k+1} + p L_1 (k < 7), L_7 = 1 + p L_1, L_0 = 1 + 2 p L_1. Written as L_k = a + b L_1:
  const double p = 0.5 - 0.5 * std::erfc(kControlSigmas / std::numbers::sqrt2);
  double a = 1.0;
  double b = p;
  for (int k = 6; k >= 1; --k) {
    a = 1.0 + p * a;
    b = p * b + p;
  }
  const double exact = 1.0 + 2.0 * p * a / (1.0 - b);
  EXPECT_NEAR(exact, 152.73, 5e-3);

  const ControlLimits known{.sigma = 1.0, .lower = -kControlSigmas, .upper = kControlSigmas};
  constexpr int kCharts = 20000;
  double mean = 0.0;
  for (int chart = 0; chart < kCharts; ++chart) {
    base::Random random(static_cast<std::uint64_t>(chart), 32);
    std::vector<double> window;
    int length = 0;
    do {
      if (window.size() == kControlRun) window.erase(window.begin());
      window.push_back(random.gaussian());
      ++length;
    } while (judge(known, window).verdict == ControlVerdict::in_control);
    mean += static_cast<double>(length) / kCharts;
  }
  // The length is nearly geometric: its standard deviation is about its mean. Four standard errors.
  EXPECT_NEAR(mean, exact, 4.0 * exact / std::sqrt(kCharts));
}

/// Share of the values of processes in control that are found out of control when `before` came before them.
double false_alarms(std::size_t before, int charts) {
  int alarms = 0;
  for (int chart = 0; chart < charts; ++chart) {
    const auto values = steady(before + 1, 1000 * before + static_cast<std::uint64_t>(chart) * 7919);
    const auto limits = control_limits(std::span(values).first(before));
    alarms += judge(*limits, values).verdict == ControlVerdict::out_of_control ? 1 : 0;
  }
  return static_cast<double>(alarms) / charts;
}

TEST(ControlChart, FalseAlarmsWithEstimatedLimitsAreAsOftenAsStated) {
  // docs/check-standard.md; the numbers are from another program (std::mt19937_64, 400,000 charts each). Four standard
  // errors of both: 4 √(p/40,000 + p/400,000).
  constexpr int kCharts = 40000;
  const auto tolerance = [](double p) { return 4.0 * std::sqrt(1.1 * p / kCharts); };
  EXPECT_NEAR(false_alarms(10, kCharts), 0.0240, tolerance(0.0240));
  EXPECT_NEAR(false_alarms(25, kCharts), 0.0130, tolerance(0.0130));
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

TEST(ControlChart, AValueBeyondThreeSigmaIsOutAndLeavesTheLimitsAsTheyWere) {
  const ControlLimits limits = control_limits(kTen).value();
  // Both sides of the limit, a thousandth of sigma apart.
  const double step = 1e-3 * limits.sigma;
  EXPECT_EQ(control_chart(ten_and({limits.upper - step})).back().verdict, ControlVerdict::in_control);
  EXPECT_EQ(control_chart(ten_and({limits.lower + step})).back().verdict, ControlVerdict::in_control);
  EXPECT_TRUE(control_chart(ten_and({limits.lower - step})).back().beyond_limits);
  const auto chart = control_chart(ten_and({limits.upper + step, 5.0}));
  EXPECT_TRUE(chart[10].beyond_limits);
  EXPECT_FALSE(chart[10].run);
  EXPECT_EQ(chart[10].verdict, ControlVerdict::out_of_control);
  EXPECT_EQ(chart[11].verdict, ControlVerdict::in_control);
  EXPECT_EQ(chart[11].limits->values, 10u);
  EXPECT_EQ(chart[11].limits->upper, limits.upper);
}

TEST(ControlChart, TheEighthValueOnOneSideIsOutAndTheSeventhIsNot) {
  const ControlLimits limits{.centre = 0.0, .lower = -3.0, .upper = 3.0};
  std::vector<double> values = {-0.1, 0.1, 0.2, 0.1, 0.3, 0.1, 0.2, 0.1};
  EXPECT_EQ(judge(limits, values).verdict, ControlVerdict::in_control);
  values.push_back(0.4);
  EXPECT_TRUE(judge(limits, values).run);
  EXPECT_FALSE(judge(limits, values).beyond_limits);
  EXPECT_EQ(judge(limits, values).verdict, ControlVerdict::out_of_control);
  values.push_back(0.0);  // on the centre: on neither side
  EXPECT_FALSE(judge(limits, values).run);
  values.insert(values.end(), 7, -0.1);
  EXPECT_FALSE(judge(limits, values).run);
  values.push_back(-0.1);
  EXPECT_TRUE(judge(limits, values).run);
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
  EXPECT_FALSE(control_limits(std::vector<double>(20, 3.0)));
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
