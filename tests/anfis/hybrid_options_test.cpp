// SPDX-License-Identifier: Apache-2.0
// Why hybrid learning stops, which model it keeps, and what it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anfis/train/learner.h"
#include "support.h"

namespace soak::anfis {
namespace {

Training trained(const HybridOptions& options, const TrainingData* checking = nullptr) {
  const TrainingData data = test::drift_problem(1, 4).data;
  return *train_hybrid(test::grid(data), data, options, checking);
}

TEST(HybridLearning, StopsAfterTheGivenNumberOfEpochs) {
  const TrainingSummary summary = trained({.epochs = 12}).summary;
  EXPECT_EQ(summary.reason, StopReason::epochs_done);
  EXPECT_EQ(summary.history.size(), 12U);
  EXPECT_NE(summary.one_line().find("epochs done after 12 epochs"), std::string::npos);
}

TEST(HybridLearning, StopsAtTheGoal) {
  const TrainingSummary summary = trained({.rmse_goal = 1.0}).summary;
  EXPECT_EQ(summary.reason, StopReason::goal_reached);
  EXPECT_EQ(summary.history.size(), 1U);
}

TEST(HybridLearning, StopsAtOnceAtAnErrorOfZero) {
  TrainingData zero = test::drift_problem(1, 4).data;
  std::fill(zero.y.begin(), zero.y.end(), 0.0);
  const auto training = train_hybrid(test::grid(zero), zero);
  EXPECT_EQ(training->summary.reason, StopReason::goal_reached);  // an error of 0 meets every goal
  EXPECT_EQ(evaluate(training->model, 20.0), 0.0);
}

TEST(HybridLearning, StopsWhereTheErrorHardlyFalls) {
  const TrainingSummary summary = trained({.epochs = 1000, .min_rmse_change = 0.01}).summary;
  EXPECT_EQ(summary.reason, StopReason::converged);
  EXPECT_LT(summary.history.size(), 1000U);
}

// One rule that asks about nothing: there is no premise to move.
TEST(HybridLearning, StopsWhereNoPremiseMatters) {
  const TrainingData data = test::drift_problem(1, 4).data;
  Model line = test::grid(data);
  line.inputs[0].memberships.clear();
  line.rules.resize(1);
  line.rules[0].premise = {kAny};
  const auto training = train_hybrid(line, data);
  ASSERT_TRUE(training);
  EXPECT_EQ(training->summary.reason, StopReason::stationary);
  EXPECT_EQ(training->summary.history.size(), 1U);
}

TEST(HybridLearning, StopsWhenPatienceWithTheCheckingErrorEnds) {
  const TrainingData train = test::gyro_drift(true), check = test::gyro_drift(false);
  const auto training = train_hybrid(test::grid(train, 10), train, {.epochs = 1000, .patience = 7}, &check);
  ASSERT_TRUE(training);
  EXPECT_EQ(training->summary.reason, StopReason::patience);
  EXPECT_EQ(static_cast<int>(training->summary.history.size()), training->summary.best_epoch + 7);
}

TEST(HybridLearning, KeepsTheModelOfTheLeastTrainingErrorWhereAskedTo) {
  const TrainingData train = test::gyro_drift(true), check = test::gyro_drift(false);
  const auto training = train_hybrid(test::grid(train, 10), train, {.keep_by_training_error = true}, &check);
  ASSERT_TRUE(training);
  const auto& history = training->summary.history;
  const auto less = [](const auto& a, const auto& b) { return a.train_rmse < b.train_rmse; };
  const auto least = std::min_element(history.begin(), history.end(), less);
  EXPECT_EQ(training->summary.best_epoch, least - history.begin() + 1);
  EXPECT_NEAR(shape_rmse(train, training->model), least->train_rmse, 1e-12);
}

// A step of half the range in every epoch.
TEST(HybridLearning, NeverHoldsAValueThatIsNotFinite) {
  const HybridOptions options{.epochs = 300, .initial_step = 1.0, .step_increase = 2.0};
  const auto fault = [&](const TrainingData& data, const Model& initial) {
    const auto training = train_hybrid(initial, data, options);
    if (!training) return training.error().message;
    const auto status = validate(training->model);
    return status ? std::string() : status.error().message;
  };
  for (const Shape shape : kShapes) {
    const TrainingData usual = test::drift_problem(6, 4).data;
    EXPECT_EQ(fault(usual, test::grid(usual, 8, shape)), "");
    TrainingData outlier = usual;
    outlier.y[30] = 1e30;
    EXPECT_EQ(fault(outlier, test::grid(outlier, 8, shape)), "");
    const TrainingData sparse{{0.0, 1.0, 1.0 + 1e-12, 1000.0}, {1.0, 2.0, -2.0, 0.0}};
    EXPECT_EQ(fault(sparse, test::grid(sparse, 2, shape)), "");
  }
}

TEST(HybridLearning, WithoutBoundsStillHoldsFiniteValuesOnly) {
  const TrainingData data = test::drift_problem(6, 4).data;
  for (const Shape shape : kShapes) {
    const auto training =
        train_hybrid(test::grid(data, 8, shape), data,
                     {.epochs = 300, .initial_step = 0.5, .step_increase = 2.0, .limits = PremiseLimits::none});
    ASSERT_TRUE(training) << name(shape);
    EXPECT_TRUE(validate(training->model)) << name(shape) << ' ' << validate(training->model).error().where;
  }
}

std::string refused_option(void (*change)(HybridOptions&)) {
  HybridOptions options;
  options.epochs = 2;
  change(options);
  const TrainingData data = test::drift_problem(1, 2).data;
  const auto training = train_hybrid(test::grid(data), data, options);
  return training ? std::string("accepted") : training.error().where;
}

TEST(HybridLearning, RefusesOptionsOutOfRangeByName) {
  EXPECT_EQ(refused_option([](auto&) {}), "accepted");
  EXPECT_EQ(refused_option([](auto& o) { o.epochs = 0; }), "epochs");
  EXPECT_EQ(refused_option([](auto& o) { o.initial_step = 0.0; }), "initial_step");
  EXPECT_EQ(refused_option([](auto& o) { o.step_decrease = 1.5; }), "step_decrease");
  EXPECT_EQ(refused_option([](auto& o) { o.step_increase = 0.9; }), "step_increase");
  EXPECT_EQ(refused_option([](auto& o) { o.rmse_goal = std::nan(""); }), "rmse_goal");
  EXPECT_EQ(refused_option([](auto& o) { o.min_rmse_change = 1.0; }), "min_rmse_change");
  EXPECT_EQ(refused_option([](auto& o) { o.patience = -1; }), "patience");
  EXPECT_EQ(refused_option([](auto& o) { o.initial_covariance = 0.0; }), "initial_covariance");
  EXPECT_EQ(refused_option([](auto& o) { o.solver = ConsequentSolver::sequential; }), "group_variance");
}

TEST(HybridLearning, RefusesASmoothnessThatIsNone) {
  EXPECT_EQ(refused_option([](auto& o) { o.smoothness = -1.0; }), "smoothness");
  EXPECT_EQ(refused_option([](auto& o) { o.smoothness = std::nan(""); }), "smoothness");
  EXPECT_EQ(refused_option([](auto& o) { o.smoothness = HUGE_VAL; }), "smoothness");
}

TEST(HybridLearning, RefusesASmoothnessOfSeveralInputs) {
  TrainingData data{{0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5, 0.3}, {1.0, 2.0, 3.0, 5.0, 2.0}};
  data.inputs = 2;
  const auto training = train_hybrid(test::grid(data, 2, Shape::bell, 0), data, {.epochs = 2, .smoothness = 1e-3});
  ASSERT_FALSE(training);
  EXPECT_EQ(training.error().where, "smoothness");
}

TEST(HybridLearning, RefusesDataThatDoNotFitTheModel) {
  const TrainingData data = test::drift_problem(1, 2).data;
  EXPECT_EQ(train_hybrid(test::grid(data, 40), data).error().where, "x");  // 80 consequents, 42 distinct inputs
  TrainingData two = data;
  two.inputs = 2;
  for (auto* column : {&two.y, &two.weight}) column->resize(two.rows());
  two.group.resize(two.rows());
  EXPECT_EQ(train_hybrid(test::grid(data), two).error().where, "x");
  EXPECT_EQ(train_hybrid(test::grid(data), data, {}, &two).error().where, "checking data, x");
  Model wrong = test::grid(data);
  wrong.inputs[0].memberships[3].parameters[0] = -1.0;
  EXPECT_EQ(train_hybrid(wrong, data).error().where, "initial model, inputs[0].memberships[3].width");
}

}  // namespace
}  // namespace soak::anfis
