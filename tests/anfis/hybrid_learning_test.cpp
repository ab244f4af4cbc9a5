// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/learner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "anfis/model/one_input.h"
#include "base/random.h"
#include "support.h"

namespace soak::anfis {
namespace {

// Worst error over the range of a model trained on 151 exact values of `known`, as a share of the span.
double recovery_error(const Model& known, double low, double high, int rules) {
  TrainingData data;
  for (int i = 0; i <= 150; ++i) {
    data.x.push_back(low + (high - low) * i / 150.0);
    data.y.push_back(evaluate(known, data.x.back()));
  }
  const auto training = train_hybrid(test::grid(data, rules), data);
  EXPECT_TRUE(training);
  double worst = 0.0;
  for (int i = 0; i <= 1200; ++i) {
    const double x = low + (high - low) * i / 1200.0;
    worst = std::max(worst, std::abs(evaluate(training->model, x) - evaluate(known, x)));
  }
  const auto [least, most] = std::minmax_element(data.y.begin(), data.y.end());
  return worst / (*most - *least);
}

TEST(HybridLearning, RecoversTheFunctionOfAKnownSystemNearTheStartingGrid) {
  const std::vector<CurveRule> rules = {
      {0.5, 2.0, -0.95, 0.3, -0.4}, {0.45, 2.2, 0.05, -0.8, 0.2}, {0.55, 1.8, 0.95, 0.5, 0.1}};
  Model known = curve_model(Shape::bell, rules);
  known.inputs[0].scale = {20.0, 50.0};
  EXPECT_LT(recovery_error(known, -30.0, 70.0, 3),
            1e-3);  // the least squares of the first epoch alone leave ten times more
}

// The memberships of this system are a third as wide as those of a grid of three: with three rules steepest descent
// crawls along a narrow valley (5 % of the span after 100 epochs, 7 % after 1000). More rules represent the function
// all the same.
TEST(HybridLearning, RecoversTheFunctionOfASystemFarFromTheGridWithMoreRules) {
  const auto v = nlohmann::json::parse(test::read_vector_file("fis_bell_1in.json"));
  std::vector<CurveRule> rules;
  for (std::size_t i = 0; i < v["a"].size(); ++i) {
    rules.push_back({v["a"][i], v["b"][i], v["c"][i], v["consequents_slope"][i], v["consequents_offset"][i]});
  }
  const Model known = curve_model(Shape::bell, rules);
  const double three = recovery_error(known, -60.0, 90.0, 3);
  const double seven = recovery_error(known, -60.0, 90.0, 7);
  std::printf("known system far from the grid, worst error of the span: 3 rules %.4f, 7 rules %.4f\n", three, seven);
  EXPECT_LT(seven, 0.01);
}

// Each run covers only part of the range, the warm ones with a large offset: without the random intercept the offset
// goes into the curve.
TEST(HybridLearning, RandomInterceptsKeepRunOffsetsOutOfTheCurve) {
  base::Random random(8);
  TrainingData data;
  const auto truth = [](double x) { return 0.2 * std::sin(x / 20.0); };
  for (int run = 0; run < 8; ++run) {
    const double offset = run % 2 == 0 ? 0.5 : -0.5;
    for (int i = 0; i < 14; ++i) {
      const double x = (run % 2 == 0 ? 0.0 : 35.0) + 5.0 * i;
      data.x.push_back(x);
      data.y.push_back(truth(x) + offset + 0.002 * random.gaussian());
      data.group.push_back(run);
    }
  }
  const auto worst_shape = [&](double group_variance) {
    data.group_variance = group_variance;
    const auto training = train_hybrid(test::grid(data, 4), data);
    EXPECT_TRUE(training);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (double x = 0.0; x <= 100.0; x += 1.0) {
      const double e = evaluate(training->model, x) - truth(x);
      low = std::min(low, e);
      high = std::max(high, e);
    }
    return 0.5 * (high - low);
  };
  EXPECT_GT(worst_shape(0.0), 0.2);
  EXPECT_LT(worst_shape(0.25 / (0.002 * 0.002)), 0.01);
  EXPECT_LT(worst_shape(std::numeric_limits<double>::infinity()), 0.01);
}

TEST(HybridLearning, FreeOffsetsLeaveTheLevelAtTheMeanOfTheRuns) {
  auto problem = test::drift_problem(2, 4);
  problem.data.group_variance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < problem.data.rows(); ++i) {
    problem.data.y[i] += 7.0 + (problem.data.group[i] == 0 ? 4.0 : 0.0);  // mean of the runs: 8
  }
  const auto training = train_hybrid(test::grid(problem.data), problem.data);
  ASSERT_TRUE(training);
  double level = 0.0;
  for (double t = -30.0; t <= 70.0; t += 5.0) {
    level += (evaluate(training->model, t) - problem.truth(t)) / 21.0;
  }
  EXPECT_NEAR(level, 8.0, 0.03);  // run offsets sigma 0.02 / sqrt(4)
}

TEST(HybridLearning, KeepsTheModelOfTheLeastCheckingError) {
  const TrainingData train = test::gyro_drift(true);
  TrainingData check = test::gyro_drift(false);
  const Model initial = test::grid(train, 10);
  const auto training = train_hybrid(initial, train, {}, &check);
  ASSERT_TRUE(training);
  const auto& history = training->summary.history;
  const auto least = std::min_element(history.begin(), history.end(),
                                      [](const auto& a, const auto& b) { return a.check_rmse < b.check_rmse; });
  EXPECT_EQ(training->summary.best_epoch, least - history.begin() + 1);
  EXPECT_EQ(training->summary.check_rmse, least->check_rmse);
  EXPECT_NE(training->summary.best_epoch, static_cast<int>(history.size()));
  double sum = 0.0;
  for (std::size_t i = 0; i < check.rows(); ++i) {
    sum += std::pow(check.y[i] - evaluate(training->model, check.x[i]), 2);
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(check.rows())), least->check_rmse, 1e-12);
  check.group_variance = 1.0;
  EXPECT_LT(train_hybrid(initial, train, {}, &check)->summary.check_rmse, 0.8 * least->check_rmse);  // shape error
}

TEST(HybridLearning, GivesTheSameBitsTwice) {
  const auto problem = test::drift_problem(4, 4);
  const auto first = train_hybrid(test::grid(problem.data), problem.data);
  const auto second = train_hybrid(test::grid(problem.data), problem.data);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->model, second->model);
}

TEST(HybridLearning, DoesNotDependOnUnits) {
  const auto problem = test::drift_problem(4, 4);
  TrainingData scaled = problem.data;
  for (std::size_t i = 0; i < scaled.rows(); ++i) {
    scaled.x[i] = scaled.x[i] * 1.8 + 32.0;
    scaled.y[i] *= 3600.0;
    scaled.weight[i] /= 3600.0 * 3600.0;
  }
  scaled.group_variance *= 3600.0 * 3600.0;
  HybridOptions options;
  options.epochs = 20;
  const auto plain = train_hybrid(test::grid(problem.data), problem.data, options);
  const auto other = train_hybrid(test::grid(scaled), scaled, options);
  ASSERT_TRUE(plain && other);
  for (double t = -30.0; t <= 70.0; t += 1.0) {
    EXPECT_NEAR(evaluate(other->model, t * 1.8 + 32.0) / 3600.0, evaluate(plain->model, t), 1e-8);
  }
}

// A model that shares memberships between rules, from exact values of it on a grid of 15 x 15 points.
TEST(HybridLearning, LowersTheErrorOfASystemOfTwoInputsTenfold) {
  TrainingData data;
  data.inputs = 2;
  for (int i = 0; i < 225; ++i) {
    data.x.insert(data.x.end(), {-1.0 + i / 15 / 7.0, -1.0 + i % 15 / 7.0});
    data.y.push_back(0.0);
  }
  Model known = test::grid(data, 2);
  known.inputs[0].memberships = {bell(0.8, 1.8, -0.9), bell(1.1, 2.3, 0.95)};
  known.inputs[1].memberships = {bell(0.95, 2.2, -0.95), bell(0.9, 1.9, 0.9)};
  known.rules[0].gains = {0.5, -0.3};
  known.rules[1].offset = 1.0;
  known.rules[2].gains = {-1.0, 0.4};
  known.rules[3].offset = -0.5;
  evaluate(known, data.x, data.y);
  const auto training = train_hybrid(test::grid(data, 2), data, {.epochs = 300});
  ASSERT_TRUE(training);
  const auto& history = training->summary.history;
  EXPECT_LT(training->summary.train_rmse, 0.1 * history.front().train_rmse);
  EXPECT_LT(shape_rmse(data, training->model), 1.001 * training->summary.train_rmse);
}

// Recursive least squares from 0 and eta I is ridge regression with 1/eta [AH05 eq. 5.14]: it differs from the least
// squares by about |X| / (eta s^2), s the least singular value: near 1e-2 and X near 1 leaves 1e-2 / 1e6 * 1e4.
TEST(HybridLearning, SequentialSolverComesNearTheLeastSquaresOfTheFirstEpoch) {
  const TrainingData data = test::gyro_drift(true);
  const Model initial = test::grid(data, 4);
  const auto batch = train_hybrid(initial, data, {.epochs = 1});
  const auto sequential = train_hybrid(initial, data, {.epochs = 1, .solver = ConsequentSolver::sequential});
  ASSERT_TRUE(batch && sequential);
  EXPECT_NEAR(sequential->summary.train_rmse, batch->summary.train_rmse, 1e-6);
  for (const double t : {-35.0, 0.0, 17.0, 60.0}) {
    EXPECT_NEAR(evaluate(sequential->model, t), evaluate(batch->model, t), 1e-4);
  }
}

TEST(HybridLearning, DoesNotMoveGainsThatAreDropped) {
  const TrainingData data = test::gyro_drift(true);
  Model initial = test::grid(data, 4);
  initial.rules[2].dropped = {0};
  const auto training = train_hybrid(initial, data);
  ASSERT_TRUE(training);
  EXPECT_EQ(training->model.rules[2].gains[0], 0.0);
  EXPECT_EQ(training->model.rules[2].dropped, initial.rules[2].dropped);
  EXPECT_NE(training->model.rules[1].gains[0], 0.0);
}

}  // namespace
}  // namespace soak::anfis
