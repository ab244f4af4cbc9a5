// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/learner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "anfis/model/one_input.h"
#include "anfis/objective/projected_problem.h"
#include "anfis/premises/premise_bounds.h"
#include "sample_models.h"
#include "support.h"

namespace soak::anfis {
namespace {

/// Rows of `known` at these inputs, without noise.
TrainingData exact_rows(const Model& known, std::vector<double> x) {
  TrainingData data;
  data.inputs = known.inputs.size();
  data.x = std::move(x);
  data.y.resize(data.rows());
  evaluate(known, data.x, data.y);
  return data;
}

std::vector<double> line_of_points(int count) {
  std::vector<double> x;
  for (int i = 0; i < count; ++i) x.push_back(-30.0 + 100.0 * i / (count - 1));
  return x;
}

std::vector<double> square_of_points(int side) {
  std::vector<double> x;
  for (int i = 0; i < side * side; ++i) {
    x.insert(x.end(), {-30.0 + 100.0 * (i / side) / (side - 1), -1.0 + 2.0 * (i % side) / (side - 1)});
  }
  return x;
}

/// Memberships some way off those of a grid.
Model known_curve(Shape shape) {
  const double slope = shape == Shape::bell ? 1.0 : 0.0;
  Model model = curve_model(shape, std::vector<CurveRule>{{0.5, 2.0 * slope, -0.8, 0.3, -0.4},
                                                          {0.3, 1.6 * slope, 0.15, -0.8, 0.6},
                                                          {0.45, 2.5 * slope, 0.9, 0.5, 0.1}});
  model.inputs[0].scale = {20.0, 50.0};
  return model;
}

Model known_surface(Shape shape) {
  Model model;
  model.inputs.resize(2);
  model.inputs[0].scale = {20.0, 50.0};
  const auto member = [&](double width, double slope, double c) {
    return shape == Shape::bell ? bell(width, slope, c) : gaussian(0.8 * width, c);
  };
  model.inputs[0].memberships = {member(0.8, 1.8, -0.9), member(1.1, 2.3, 0.8)};
  model.inputs[1].memberships = {member(0.95, 2.2, -0.8), member(0.7, 1.6, 0.9)};
  model.rules = {{{0, 0}, {0.5, -0.3}, 0.1, {}},
                 {{0, 1}, {0.2, 0.6}, 1.0, {}},
                 {{1, 0}, {-1.0, 0.4}, 0.0, {}},
                 {{1, 1}, {0.3, 0.1}, -0.5, {}}};
  return model;
}

double span(const TrainingData& data) {
  const auto [low, high] = std::minmax_element(data.y.begin(), data.y.end());
  return *high - *low;
}

/// Worst error at `points` as a share of the span.
double worst_error(const Model& model, const TrainingData& points) {
  double worst = 0.0;
  for (const double r : residuals(points, model)) worst = std::max(worst, std::abs(r));
  return worst / span(points);
}

VariableProjectionOptions patient() { return {.evaluations = 2000, .min_rmse_change = 1e-9}; }

TEST(VariableProjection, RecoversAKnownCurveFromThePlainGrid) {
  for (const Shape shape : {Shape::bell, Shape::gaussian}) {
    const Model known = known_curve(shape);
    const TrainingData train = exact_rows(known, line_of_points(151)), dense = exact_rows(known, line_of_points(1201));
    const auto training = train_variable_projection(test::grid(train, 3, shape), train, patient());
    ASSERT_TRUE(training);
    const auto hybrid = train_hybrid(test::grid(train, 3, shape), train, {.epochs = 2000});
    const double error = worst_error(training->model, dense), other = worst_error(hybrid->model, dense);
    std::printf("known curve of 3 %ss: worst error of the span %.2e, hybrid %.2e\n", std::string(name(shape)).c_str(),
                error, other);
    EXPECT_LT(error, 1e-4) << name(shape);
    EXPECT_LT(error, other) << name(shape);
  }
}

TEST(VariableProjection, RecoversAKnownSurfaceFromThePlainGrid) {
  for (const Shape shape : {Shape::bell, Shape::gaussian}) {
    const Model known = known_surface(shape);
    const TrainingData train = exact_rows(known, square_of_points(15)), dense = exact_rows(known, square_of_points(40));
    const auto training = train_variable_projection(test::grid(train, 2, shape), train, patient());
    ASSERT_TRUE(training);
    const auto hybrid = train_hybrid(test::grid(train, 2, shape), train, {.epochs = 2000});
    const double error = worst_error(training->model, dense), other = worst_error(hybrid->model, dense);
    std::printf("known surface of 2 x 2 %ss: worst error of the span %.2e, hybrid %.2e\n",
                std::string(name(shape)).c_str(), error, other);
    EXPECT_LT(error, 1e-4) << name(shape);
    EXPECT_LT(error, other) << name(shape);
  }
}

// Noisy rows of every kind, one and two inputs: the record of its first evaluation is the start's error.
TEST(VariableProjection, IsNeverWorseThanItsStart) {
  for (const test::Sample& sample : test::all_samples()) {
    const auto start = train_hybrid(sample.model, sample.data, {.epochs = 1});
    ASSERT_TRUE(start) << sample.what << start.error().message;
    for (const Optimiser optimiser : {Optimiser::lbfgs, Optimiser::slsqp, Optimiser::sbplx}) {
      const auto training =
          train_variable_projection(sample.model, sample.data, {.optimiser = optimiser, .evaluations = 50});
      ASSERT_TRUE(training) << sample.what;
      EXPECT_LE(training->summary.train_rmse, start->summary.train_rmse * (1.0 + 1e-9)) << sample.what;
      EXPECT_NEAR(shape_rmse(sample.data, training->model), training->summary.train_rmse, 1e-9) << sample.what;
      EXPECT_LE(training->summary.history.size(), 50U);
      EXPECT_TRUE(validate(training->model)) << sample.what;
    }
  }
}

// What apply() would move: nothing but rounding.
double distance_from_bounds(const Model& model, const TrainingData& data, const Model& initial) {
  Model moved = model;
  training::PremiseBounds(initial, data).apply(moved);
  double distance = 0.0;
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    for (std::size_t k = 0; k < model.inputs[j].memberships.size(); ++k) {
      for (std::size_t p = 0; p < 4; ++p) {
        distance = std::max(distance, std::abs(moved.inputs[j].memberships[k].parameters[p] -
                                               model.inputs[j].memberships[k].parameters[p]));
      }
    }
  }
  return distance;
}

TEST(VariableProjection, KeepsItsBoundsOnTemperaturesOfACampaign) {
  for (const Shape shape : kShapes) {
    for (const unsigned seed : {1U, 2U, 3U, 4U}) {
      const TrainingData data = test::drift_problem(seed, 4).data;
      const Model initial = test::grid(data, 6, shape);
      const auto training = train_variable_projection(initial, data, {.starts = 3});
      ASSERT_TRUE(training);
      EXPECT_LT(distance_from_bounds(training->model, data, initial), 1e-9) << name(shape) << ' ' << seed;
    }
  }
}

TEST(VariableProjection, EveryOptimiserLowersTheErrorOfACurve) {
  const TrainingData data = test::drift_problem(3, 4).data;
  for (const Shape shape : kShapes) {
    const Model initial = test::grid(data, 5, shape);
    for (const Optimiser optimiser : {Optimiser::lbfgs, Optimiser::slsqp, Optimiser::sbplx}) {
      const auto training = train_variable_projection(initial, data, {.optimiser = optimiser, .evaluations = 1000});
      ASSERT_TRUE(training);
      const double first = training->summary.history.front().train_rmse;
      EXPECT_LT(training->summary.train_rmse, 0.95 * first) << name(shape) << static_cast<int>(optimiser);
      EXPECT_NE(training->summary.reason, StopReason::not_finite) << name(shape) << static_cast<int>(optimiser);
    }
  }
}

TEST(VariableProjection, GivesTheSameBitsForTheSameSeed) {
  const TrainingData data = test::drift_problem(4, 4).data;
  const Model initial = test::grid(data, 5);
  const VariableProjectionOptions options{.starts = 6, .seed = 9};
  const auto first = train_variable_projection(initial, data, options);
  const auto second = train_variable_projection(initial, data, options);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->model, second->model);
  EXPECT_EQ(first->summary.best_epoch, second->summary.best_epoch);
}

TEST(VariableProjection, MoreStartsAreNeverWorse) {
  const TrainingData data = test::drift_problem(4, 4).data;
  const Model initial = test::grid(data, 5);
  double previous = HUGE_VAL;
  bool better = false;
  for (const int starts : {1, 3, 10}) {
    const auto training = train_variable_projection(initial, data, {.starts = starts});
    ASSERT_TRUE(training);
    EXPECT_LE(training->summary.train_rmse, previous);
    better = better || (starts > 1 && training->summary.train_rmse < previous);
    previous = training->summary.train_rmse;
  }
  EXPECT_TRUE(better);
}

TEST(VariableProjection, KeepsTheModelOfTheLeastCheckingError) {
  const TrainingData train = test::gyro_drift(true), check = test::gyro_drift(false);
  const auto training = train_variable_projection(test::grid(train, 10), train, {}, &check);
  ASSERT_TRUE(training);
  const auto& history = training->summary.history;
  const auto less = [](const auto& a, const auto& b) { return a.check_rmse < b.check_rmse; };
  const auto least = std::min_element(history.begin(), history.end(), less);
  EXPECT_EQ(training->summary.best_epoch, least - history.begin() + 1);
  EXPECT_NEAR(shape_rmse(check, training->model), least->check_rmse, 1e-12);
}

TEST(VariableProjection, FreeOffsetsLeaveTheLevelAtTheMeanOfTheRuns) {
  auto problem = test::drift_problem(2, 4);
  problem.data.group_variance = std::numeric_limits<double>::infinity();
  for (double& y : problem.data.y) y += 7.0;
  const auto training = train_variable_projection(test::grid(problem.data), problem.data);
  ASSERT_TRUE(training);
  double level = 0.0;
  for (double t = -30.0; t <= 70.0; t += 5.0) level += (evaluate(training->model, t) - problem.truth(t)) / 21.0;
  EXPECT_NEAR(level, 7.0, 0.03);  // run offsets sigma 0.02 / sqrt(4)
}

TEST(VariableProjection, SmoothnessLowersTheCurvature) {
  const TrainingData data = test::drift_problem(4, 4).data;
  const auto curvature = [&](double smoothness) {
    const auto training = train_variable_projection(test::grid(data, 7), data, {.smoothness = smoothness});
    EXPECT_TRUE(training);
    double sum = 0.0;
    for (double t = -29.0; t <= 69.0; t += 1.0) {
      const auto f = [&](double at) { return evaluate(training->model, at); };
      sum += std::pow(f(t - 1.0) - 2.0 * f(t) + f(t + 1.0), 2);
    }
    return sum;
  };
  const double plain = curvature(0.0), smooth = curvature(1e-3), line = curvature(1e3);
  EXPECT_LT(smooth, 0.9 * plain);
  EXPECT_LT(line, 1e-3 * plain);
}

// The error that counts has the price in it: E, not the training error alone, decides which start and which evaluation
// is kept.
TEST(VariableProjection, KeepsTheLeastErrorWithThePriceOfCurvatureInIt) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const TrainingData data = test::drift_problem(seed, 4).data;
    const Model initial = test::grid(data, 7, Shape::gaussian);
    const double smoothness = 1e-5;
    const auto error = [&](int starts) {
      const auto trained =
          train_variable_projection(initial, data, {.smoothness = smoothness, .starts = starts}).value();
      training::ProjectedProblem problem(trained.model, data, smoothness);
      problem.solve();
      return problem.error();
    };
    EXPECT_LE(error(8), error(1) * (1.0 + 1e-9)) << seed;
  }
}

// The limits are measured in the data's own range: a model in the units of the data is held as one in scaled units is.
TEST(VariableProjection, DoesNotDependOnTheUnitsOfAModelThatIsNotScaled) {
  const TrainingData data = test::drift_problem(1, 4).data;
  RuleBaseOptions options;
  options.shape = Shape::gaussian;
  const auto scaled = train_variable_projection(grid_rules(data, options).value(), data).value();
  options.scale = false;
  TrainingData milli = data;
  for (double& x : milli.x) x *= 1000.0;
  const auto raw = train_variable_projection(grid_rules(milli, options).value(), milli).value();
  EXPECT_NEAR(raw.summary.train_rmse / scaled.summary.train_rmse, 1.0, 0.02);
  EXPECT_NEAR(evaluate(raw.model, 20000.0), evaluate(scaled.model, 20.0), 1e-3);
}

}  // namespace
}  // namespace soak::anfis
