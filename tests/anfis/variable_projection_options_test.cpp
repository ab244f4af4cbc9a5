// SPDX-License-Identifier: Apache-2.0
// Why variable projection stops, and what it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anfis/train/learner.h"
#include "support.h"

namespace soak::anfis {
namespace {

TrainingSummary summary_of(const VariableProjectionOptions& options) {
  const TrainingData data = test::drift_problem(1, 4).data;
  return train_variable_projection(test::grid(data), data, options)->summary;
}

TEST(VariableProjection, StopsAfterTheGivenNumberOfEvaluations) {
  for (const Optimiser optimiser : {Optimiser::lbfgs, Optimiser::slsqp, Optimiser::sbplx}) {
    const TrainingSummary summary = summary_of({.optimiser = optimiser, .evaluations = 7});
    EXPECT_EQ(summary.reason, StopReason::epochs_done) << static_cast<int>(optimiser);
    EXPECT_EQ(summary.history.size(), 7U) << static_cast<int>(optimiser);
  }
  EXPECT_EQ(summary_of({.evaluations = 1}).history.size(), 1U);
}

TEST(VariableProjection, StopsWhereTheErrorHardlyFalls) {
  for (const Optimiser optimiser : {Optimiser::lbfgs, Optimiser::slsqp}) {
    const TrainingSummary summary = summary_of({.optimiser = optimiser, .evaluations = 5000, .min_rmse_change = 1e-4});
    EXPECT_EQ(summary.reason, StopReason::converged) << static_cast<int>(optimiser);
    EXPECT_LT(summary.history.size(), 5000U);
  }
}

TEST(VariableProjection, StopsAtTheGoal) {
  const TrainingSummary free = summary_of({});
  const double goal = 0.5 * (free.history.front().train_rmse + free.train_rmse);
  const TrainingSummary summary = summary_of({.rmse_goal = goal});
  EXPECT_EQ(summary.reason, StopReason::goal_reached);
  EXPECT_LE(summary.train_rmse, goal);
  EXPECT_LT(summary.history.size(), free.history.size());
  EXPECT_EQ(summary_of({.rmse_goal = 1.0}).history.size(), 1U);
}

TEST(VariableProjection, StopsAtOnceAtAnErrorOfZero) {
  TrainingData zero = test::drift_problem(1, 4).data;
  std::fill(zero.y.begin(), zero.y.end(), 0.0);
  const auto training = train_variable_projection(test::grid(zero), zero);
  ASSERT_TRUE(training);
  EXPECT_EQ(training->summary.reason, StopReason::goal_reached);  // an error of 0 meets every goal
  EXPECT_EQ(evaluate(training->model, 20.0), 0.0);
}

// One rule that asks about nothing: there is no premise to move.
TEST(VariableProjection, StopsWhereNoPremiseMatters) {
  const TrainingData data = test::drift_problem(1, 4).data;
  Model line = test::grid(data);
  line.inputs[0].memberships.clear();
  line.rules.resize(1);
  line.rules[0].premise = {kAny};
  const auto training = train_variable_projection(line, data);
  ASSERT_TRUE(training) << training.error().message;
  EXPECT_TRUE(training->summary.reason == StopReason::stationary || training->summary.reason == StopReason::converged)
      << name(training->summary.reason);
  EXPECT_NE(training->model.rules[0].gains[0], 0.0);
}

std::string where_of(void (*change)(VariableProjectionOptions&)) {
  VariableProjectionOptions options{.evaluations = 3};
  change(options);
  const TrainingData data = test::drift_problem(1, 2).data;
  const auto training = train_variable_projection(test::grid(data), data, options);
  return training ? std::string("accepted") : training.error().where;
}

TEST(VariableProjection, RefusesOptionsOutOfRangeByName) {
  EXPECT_EQ(where_of([](auto&) {}), "accepted");
  EXPECT_EQ(where_of([](auto& o) { o.evaluations = 0; }), "evaluations");
  EXPECT_EQ(where_of([](auto& o) { o.min_rmse_change = 1.0; }), "min_rmse_change");
  EXPECT_EQ(where_of([](auto& o) { o.min_rmse_change = std::nan(""); }), "min_rmse_change");
  EXPECT_EQ(where_of([](auto& o) { o.rmse_goal = -1.0; }), "rmse_goal");
  EXPECT_EQ(where_of([](auto& o) { o.limits = PremiseLimits::none; }), "limits");
  EXPECT_EQ(where_of([](auto& o) { o.starts = 0; }), "starts");
  EXPECT_EQ(where_of([](auto& o) { o.spread = 0.0; }), "spread");
}

TEST(VariableProjection, RefusesASmoothnessThatIsNone) {
  EXPECT_EQ(where_of([](auto& o) { o.smoothness = -1.0; }), "smoothness");
  EXPECT_EQ(where_of([](auto& o) { o.smoothness = std::nan(""); }), "smoothness");
  EXPECT_EQ(where_of([](auto& o) { o.smoothness = HUGE_VAL; }), "smoothness");
}

TEST(VariableProjection, RefusesWhatHybridLearningRefuses) {
  const TrainingData data = test::drift_problem(1, 2).data;
  EXPECT_EQ(train_variable_projection(test::grid(data, 40), data).error().where, "x");
  Model wrong = test::grid(data);
  wrong.inputs[0].memberships[3].parameters[0] = -1.0;
  EXPECT_EQ(train_variable_projection(wrong, data).error().where, "initial model, inputs[0].memberships[3].width");
  TrainingData check = data;
  check.y[1] = HUGE_VAL;
  EXPECT_EQ(train_variable_projection(test::grid(data), data, {}, &check).error().where, "checking data, row 1");
}

}  // namespace
}  // namespace soak::anfis
