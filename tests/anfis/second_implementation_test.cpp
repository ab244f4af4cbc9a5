// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "anfis/model/rule_base.h"
#include "anfis/train/learner.h"
#include "base/random.h"
#include "plain_learner.h"

// train_hybrid() against PlainLearner, epoch by epoch. Rows are drawn at random, so that none lies on a kink.
namespace soak::anfis {
namespace {

constexpr int kEpochs = 20;

TrainingData random_rows(std::size_t rows, std::size_t inputs, bool whitened) {
  base::Random random(3, inputs);
  TrainingData data;
  data.inputs = inputs;
  for (std::size_t i = 0; i < rows; ++i) {
    double y = 0.0;
    for (std::size_t j = 0; j < inputs; ++j) {
      data.x.push_back(random.uniform(10.0, 90.0));
      y += std::sin(data.x.back() / (15.0 + 4.0 * static_cast<double>(j))) + 0.003 * data.x.back() * (1.0 + y);
    }
    const auto third = static_cast<int>(i % 3);
    data.y.push_back(100.0 * (y + (whitened ? 0.5 * third : 0.0) + 0.01 * random.gaussian()));
    if (!whitened) continue;
    data.weight.push_back(1.0 + 0.5 * static_cast<double>(i % 4));
    data.group.push_back(third);
  }
  data.group_variance = whitened ? 0.4 : 0.0;
  return data;
}

void expect_same_training(const Model& initial, const TrainingData& data, const std::string& what) {
  HybridOptions options;
  options.epochs = kEpochs;
  options.limits = PremiseLimits::none;
  const auto training = train_hybrid(initial, data, options);
  ASSERT_TRUE(training) << what << ": " << training.error().message;
  const auto& history = training->summary.history;
  const auto expected = test::PlainLearner(initial, data, options).learn();
  ASSERT_EQ(history.size(), expected.size()) << what;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    // Central differences of step 1e-6 are good to about 1e-10 of the gradient; steps of 0.01 add up over the epochs,
    // and the fit multiplies what they differ by.
    EXPECT_NEAR(history[i].train_rmse / expected[i].rmse, 1.0, 1e-7) << what << ", epoch " << i + 1;
    EXPECT_DOUBLE_EQ(history[i].step, expected[i].step) << what << ", epoch " << i + 1;
  }
  EXPECT_GT(std::abs(expected.back().rmse / expected.front().rmse - 1.0), 1e-4) << what << ": premises do not matter";
}

/// Four memberships of different size that overlap without repeating each other; none has a kink on the ends of the
/// data, where a grid has its peaks.
std::vector<Membership> uneven(Shape shape) {
  std::vector<Membership> memberships;
  for (const double centre : {-1.03, -0.31, 0.36, 1.02}) {
    memberships.push_back(membership_around(shape, centre, 0.45 + 0.1 * centre));
  }
  return memberships;
}

Model one_input(const TrainingData& data, Shape shape, int order) {
  Model model = grid_rules(data, {.memberships = {4}, .shape = shape, .order = order}).value();
  model.inputs[0].memberships = uneven(shape);
  return model;
}

TEST(SecondImplementation, FollowsEveryShapeAndOrderOfOneInput) {
  for (const bool whitened : {false, true}) {
    const TrainingData data = random_rows(45, 1, whitened);
    for (const Shape shape : kShapes) {
      for (const int order : {0, 1}) {
        expect_same_training(one_input(data, shape, order), data,
                             std::string(name(shape)) + " order " + std::to_string(order));
      }
    }
  }
}

TEST(SecondImplementation, FollowsGridsOfTwoInputsWithBothTNorms) {
  const TrainingData data = random_rows(60, 2, true);
  for (const TNorm t_norm : {TNorm::product, TNorm::minimum}) {
    for (const Shape shape : {Shape::bell, Shape::gaussian}) {
      const Model grid = grid_rules(data, {.memberships = {2, 3}, .shape = shape, .t_norm = t_norm}).value();
      expect_same_training(grid, data, std::string(name(t_norm)) + ' ' + std::string(name(shape)));
    }
  }
}

// Five rules of their own memberships of three inputs, some of which ask about one or two inputs only, and whose
// consequents lack some gains.
Model scatter(const TrainingData& data, TNorm t_norm) {
  Eigen::MatrixXd centres(5, 3), widths(5, 3);
  centres << 20, 30, 70, 80, 20, 60, 50, 50, 50, 30, 80, 20, 70, 70, 30;
  widths << 30, 40, 25, 35, 30, 30, 40, 25, 35, 30, 35, 30, 45, 30, 40;
  Model model = scatter_rules(data, centres, widths, {.shape = Shape::gaussian, .t_norm = t_norm}).value();
  model.rules[0].premise[1] = kAny;
  model.rules[3].premise[0] = kAny;
  model.rules[3].premise[2] = kAny;
  model.rules[1].dropped = {0, 2};
  model.rules[2].dropped = {1};
  model.rules[4].dropped = {0, 1, 2};
  return model;
}

TEST(SecondImplementation, FollowsScatteredRulesThatLeaveOutPremisesAndGains) {
  for (const bool whitened : {false, true}) {
    const TrainingData data = random_rows(60, 3, whitened);
    for (const TNorm t_norm : {TNorm::product, TNorm::minimum}) {
      expect_same_training(scatter(data, t_norm), data, "scatter " + std::string(name(t_norm)));
    }
  }
}

TEST(SecondImplementation, FollowsMixedShapesInOneModel) {
  const TrainingData data = random_rows(60, 2, true);
  Model model = grid_rules(data, {.memberships = {3, 2}}).value();
  model.inputs[0].memberships = {{Shape::trapezoid, {-2.1, -1.4, -0.7, 0.4}},
                                 {Shape::two_sided_gaussian, {0.4, -0.12, 0.5, 0.17}},
                                 {Shape::triangle, {-0.3, 1.07, 2.2}}};
  model.inputs[1].memberships[1] = gaussian(0.9, 0.95);
  expect_same_training(model, data, "mixed");
}

TEST(SecondImplementation, SeesStepsRiseAndFall) {
  const TrainingData data = random_rows(60, 1, false);
  HybridOptions options;
  options.epochs = 80;  // the step rises until the error zigzags
  options.limits = PremiseLimits::none;
  options.initial_step = 0.02;
  const Model initial = one_input(data, Shape::gaussian, 0);
  const auto training = train_hybrid(initial, data, options);
  ASSERT_TRUE(training);
  const auto expected = test::PlainLearner(initial, data, options).learn();
  bool rose = false, fell = false;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_DOUBLE_EQ(training->summary.history[i].step, expected[i].step) << i;
    rose = rose || (i > 0 && expected[i].step > expected[i - 1].step);
    fell = fell || (i > 0 && expected[i].step < expected[i - 1].step);
  }
  EXPECT_TRUE(rose && fell);
}

}  // namespace
}  // namespace soak::anfis
