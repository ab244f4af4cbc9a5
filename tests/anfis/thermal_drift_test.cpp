// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "anfis/hybrid_learning.h"
#include "anfis/rule_search.h"
#include "support.h"

namespace soak::anfis {
namespace {

struct Outcome {
  std::vector<double> anfis;   // worst error between temperatures, sorted
  std::vector<double> spline;  // the same of the spline through plateau means
  std::map<int, int> rules;
};

Outcome run_campaigns(int runs, Membership membership) {
  Outcome outcome;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const test::DriftProblem problem = test::drift_problem(seed, runs);
    RuleSearchOptions options;
    options.training.membership = membership;
    const auto search = search_rules(problem.data, test::folds_by_group(problem.data, std::min(runs, 5)), options);
    EXPECT_TRUE(search);
    HybridOptions training_options = options.training;
    training_options.rules = search->chosen;
    const auto training = train_hybrid(problem.data, training_options);
    EXPECT_TRUE(training);
    ++outcome.rules[search->chosen];
    outcome.anfis.push_back(worst_shape_error(problem, [&](double t) { return evaluate(training->model, t); }));
    outcome.spline.push_back(worst_shape_error(problem, test::plateau_spline(problem.data, -30.0, 5.0, 21)));
  }
  std::sort(outcome.anfis.begin(), outcome.anfis.end());
  std::sort(outcome.spline.begin(), outcome.spline.end());
  std::printf("%2d runs, %-8s: median %.4f p90 %.4f worst %.4f; spline %.4f %.4f %.4f; rules", runs,
              std::string(name(membership)).c_str(), outcome.anfis[10], outcome.anfis[18], outcome.anfis[19],
              outcome.spline[10], outcome.spline[18], outcome.spline[19]);
  for (const auto& [rules, count] : outcome.rules) {
    std::printf(" %d (%d)", rules, count);
  }
  std::printf("\n");
  return outcome;
}

// The curve spans 0.5: 0.005 is the hundredth part that [AH05 §6.4.3] reports at the plateaus; here it is asked for
// between them too. The noise alone (0.002 / sqrt(runs) a plateau) puts the spline at 0.0032 and 0.0017.
class ThermalDrift : public testing::TestWithParam<Membership> {};

TEST_P(ThermalDrift, IsLearnedToAHundredthBetweenTemperaturesFromFourRuns) {
  EXPECT_LE(run_campaigns(4, GetParam()).anfis.back(), 0.005);
}

TEST_P(ThermalDrift, GetsBetterWithTwentyRuns) {
  const Outcome outcome = run_campaigns(20, GetParam());
  EXPECT_LE(outcome.anfis[18], 0.003);
  EXPECT_LE(outcome.anfis.back(), 0.005);
}

INSTANTIATE_TEST_SUITE_P(Memberships, ThermalDrift, testing::Values(Membership::bell, Membership::gaussian),
                         [](const auto& info) { return std::string(name(info.param)); });

double shape_error(const TrainingData& held_out, const std::function<double(double)>& f) {
  TrainingData data = held_out;
  data.group_variance = 1.0;
  std::vector<double> residuals;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    residuals.push_back(data.y[i] - f(data.x[i]));
  }
  return shape_rmse(data, residuals);
}

// 13 runs to learn from, 7 that nothing has seen: rules are chosen by folds inside the 13. The noise of the 7 runs
// alone is 0.1942 deg/h in shape. A curve of 14 free consequents from 13 runs of noise 0.205 adds 0.205 sqrt(14 / 273)
// = 0.046 in quadrature: 0.1997 at best, 1.028 of the floor. Measured 1.051 (7 rules; a group variance ten times as
// large leads to 6 rules and 1.065), spline 1.044: the bump, narrower than the spacing of the temperatures, is not
// fully fitted. The bound covers both choices; 1.05 is met only with the 7 runs in the loop.
TEST(GyroDrift, OnUnseenRunsComesNearTheNoiseFloor) {
  constexpr double kFloor = 0.1942;
  TrainingData train = test::gyro_drift(true);
  train.group_variance = 1.0;  // of the size of the noise variance, as the weights are 1: relative to it
  const TrainingData held_out = test::gyro_drift(false);
  const auto search = search_rules(train, test::folds_by_group(train, 5), {});
  ASSERT_TRUE(search);
  HybridOptions options;
  options.rules = search->chosen;
  const auto training = train_hybrid(train, options);
  ASSERT_TRUE(training);
  const double error = shape_error(held_out, [&](double t) { return evaluate(training->model, t); });
  const double spline = shape_error(held_out, test::plateau_spline(train, -40.0, 6.0, 21));
  std::printf("unseen runs: %d rules, shape RMSE %.4f deg/h = %.3f of the floor; spline %.4f = %.3f\n", search->chosen,
              error, error / kFloor, spline, spline / kFloor);
  EXPECT_LE(error, 1.08 * kFloor);
}

// The thesis' own use of 13 and 7 runs [AH05 §6.4.1]: the 7 stop the training and choose the rules, so this figure is
// not an unseen one.
TEST(GyroDrift, WithCheckingRunsInTheLoopReachesTheNoiseFloorOfThem) {
  constexpr double kFloor = 0.1942;
  TrainingData train = test::gyro_drift(true);
  TrainingData check = test::gyro_drift(false);
  train.group_variance = check.group_variance = 1.0;
  double least = HUGE_VAL;
  for (int rules = 4; rules <= 8; ++rules) {
    HybridOptions options;
    options.rules = rules;
    const auto training = train_hybrid(train, options, &check);
    ASSERT_TRUE(training);
    std::printf("checking runs in the loop: %d rules, %s\n", rules, training->summary.one_line().c_str());
    least = std::min(least, training->summary.check_rmse);
  }
  EXPECT_LE(least, 1.05 * kFloor);
}

TEST(HybridLearningSpeed, IsPrinted) {
  TrainingData train = test::gyro_drift(true);
  ASSERT_EQ(train.rows(), 273U);
  const auto seconds = [](auto&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const double epoch = seconds([&] { EXPECT_TRUE(train_hybrid(train, {})); }) / 100.0;
  std::printf("one epoch, 6 rules, 273 rows: %.3f ms\n", 1e3 * epoch);
  for (const auto& [runs, passes] : {std::pair{4, 2}, std::pair{20, 1}}) {
    const auto problem = test::drift_problem(1, runs, passes);
    const double search = seconds([&, folds = std::min(runs, 5)] {
      EXPECT_TRUE(search_rules(problem.data, test::folds_by_group(problem.data, folds), {}));
    });
    std::printf("rule search, %d runs of %d rows: %.3f s\n", runs, 21 * passes, search);
  }
}

}  // namespace
}  // namespace soak::anfis
