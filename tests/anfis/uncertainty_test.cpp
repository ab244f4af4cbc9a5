// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "anfis/model/one_input.h"
#include "anfis/train/learner.h"
#include "base/random.h"
#include "curves.h"
#include "support.h"

namespace soak::anfis {
namespace {

const Model& truth() {
  static const Model model = [] {
    const std::vector<CurveRule> rules = {
        {0.5, 2.0, -0.95, 0.3, -0.4}, {0.45, 2.2, 0.05, -0.8, 0.2}, {0.55, 1.8, 0.95, 0.5, 0.1}};
    Model curve = curve_model(Shape::bell, rules);
    curve.inputs[0].scale = {20.0, 50.0};
    curve.inputs[0].min = -30.0;
    curve.inputs[0].max = 70.0;
    return curve;
  }();
  return model;
}

constexpr int kRuns = 8;
constexpr double kNoise = 0.02, kRunSigma = 0.05;

TrainingData simulate(unsigned seed) {
  base::Random random(seed, 5);
  TrainingData data;
  for (int run = 0; run < kRuns; ++run) {
    const double offset = kRunSigma * random.gaussian();
    for (int i = 0; i <= 20; ++i) {
      data.x.push_back(-30.0 + 5.0 * i);
      data.y.push_back(evaluate(truth(), data.x.back()) + offset + kNoise * random.gaussian());
      data.weight.push_back(1.0 / (kNoise * kNoise));
      data.group.push_back(run);
    }
  }
  data.group_variance = kRunSigma * kRunSigma;
  return data;
}

// As thermal curves are learned: a price of curvature, and more rules than the truth needs.
TEST(PredictionVariance, WithAPriceOfCurvatureTheBandOf95PercentCoversTheTruth) {
  constexpr unsigned kSeeds = 100;
  int covered = 0, points = 0;
  double parameters = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const test::DriftProblem problem = test::drift_problem(seed, 8);
    const Model model = test::learn_curve(problem.data, 7, Shape::gaussian);
    const auto variance = PredictionVariance::of(model, problem.data, test::curve_learner().smoothness);
    ASSERT_TRUE(variance);
    parameters += variance->effective_parameters() / kSeeds;
    // The level of the runs' mean, 0.02 / sqrt(8), belongs to the band: the truth has no offset.
    for (double t = -30.0; t <= 70.0; t += 2.5) {
      const double error = evaluate(model, t) - problem.truth(t);
      covered += std::abs(error) <= 1.96 * std::sqrt(variance->at(t)) ? 1 : 0;
      ++points;
    }
  }
  const double share = static_cast<double>(covered) / points;
  std::printf("coverage with a price of curvature: %.3f, effective parameters %.1f of 28\n", share, parameters);
  // The level error is common to all points of a seed: standard error of the share about sqrt(0.05 * 0.95 / 100) =
  // 0.022.
  EXPECT_GE(share, 0.88);
  EXPECT_LE(share, 0.995);
  EXPECT_LT(parameters, 28.0);
}

TEST(PredictionVariance, ParametersFromNormalEquationsAreThoseOfTheDecomposition) {
  const test::DriftProblem problem = test::drift_problem(5, 3);
  const double price = test::curve_learner().smoothness;
  for (int rules = 2; rules <= 9; ++rules) {
    const Model model = test::learn_curve(problem.data, rules, rules % 2 == 0 ? Shape::bell : Shape::gaussian);
    const auto variance = PredictionVariance::of(model, problem.data, price);
    const auto parameters = effective_parameters(model, problem.data, price);
    ASSERT_TRUE(variance && parameters);
    // Squared singular values lose half the digits of those at the tolerance of 1e-6.
    EXPECT_NEAR(*parameters, variance->effective_parameters(), 0.02 * variance->effective_parameters()) << rules;
  }
}

TEST(PredictionVariance, BandOf95PercentCoversTheTruth) {
  constexpr int kSeeds = 300;
  int covered = 0, points = 0;
  double residual_variance = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const TrainingData data = simulate(seed);
    const auto training = train_hybrid(test::grid(data, 3), data);
    ASSERT_TRUE(training);
    const auto variance = PredictionVariance::of(training->model, data);
    ASSERT_TRUE(variance);
    residual_variance += variance->residual_variance() / kSeeds;
    for (double t = -30.0; t <= 70.0; t += 2.5) {
      const double error = evaluate(training->model, t) - evaluate(truth(), t);
      covered += std::abs(error) <= 1.96 * std::sqrt(variance->at(t)) ? 1 : 0;
      ++points;
    }
  }
  const double share = static_cast<double>(covered) / points;
  std::printf("coverage of the 95 %% band: %.3f, residual variance %.3f\n", share, residual_variance);
  // The level error is common to all points of a seed: standard error of the share about sqrt(0.05 * 0.95 / 300) =
  // 0.013.
  EXPECT_GE(share, 0.90);
  EXPECT_LE(share, 0.98);
  EXPECT_NEAR(residual_variance, 1.0, 0.05);
}

/// 2 x 2 bells over temperature and its rate.
const Model& surface() {
  static const Model model = [] {
    Model m;
    m.inputs = {{"", {20.0, 50.0}, -30.0, 70.0, {bell(0.9, 1.8, -0.95), bell(1.0, 2.2, 0.9)}},
                {"", {0.0, 1.0}, -1.0, 1.0, {bell(0.95, 2.1, -0.9), bell(0.9, 1.7, 0.95)}}};
    m.rules = {{{0, 0}, {0.5, -0.3}, 0.1, {}},
               {{0, 1}, {0.2, 0.6}, 1.0, {}},
               {{1, 0}, {-1.0, 0.4}, 0.0, {}},
               {{1, 1}, {0.3, 0.1}, -0.5, {}}};
    return m;
  }();
  return model;
}

TrainingData simulate_surface(unsigned seed) {
  base::Random random(seed, 6);
  TrainingData data;
  data.inputs = 2;
  for (int run = 0; run < kRuns; ++run) {
    const double offset = kRunSigma * random.gaussian();
    for (int i = 0; i < 49; ++i) {
      data.x.insert(data.x.end(), {-30.0 + 100.0 / 6.0 * (i / 7), -1.0 + (i % 7) / 3.0});
      data.y.push_back(evaluate(surface(), data.row(data.y.size())) + offset + kNoise * random.gaussian());
      data.weight.push_back(1.0 / (kNoise * kNoise));
      data.group.push_back(run);
    }
  }
  data.group_variance = kRunSigma * kRunSigma;
  return data;
}

TEST(PredictionVariance, BandOf95PercentCoversTheTruthOfTwoInputs) {
  constexpr int kSeeds = 150;
  int covered = 0, points = 0;
  double residual_variance = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const TrainingData data = simulate_surface(seed);
    const auto training = train_variable_projection(test::grid(data, 2), data);
    ASSERT_TRUE(training);
    const auto variance = PredictionVariance::of(training->model, data);
    ASSERT_TRUE(variance);
    residual_variance += variance->residual_variance() / kSeeds;
    for (int i = 0; i < 81; ++i) {
      const std::vector<double> x = {-30.0 + 12.5 * (i / 9), -1.0 + 0.25 * (i % 9)};
      const double error = evaluate(training->model, x) - evaluate(surface(), x);
      covered += std::abs(error) <= 1.96 * std::sqrt(variance->at(x)) ? 1 : 0;
      ++points;
    }
  }
  const double share = static_cast<double>(covered) / points;
  std::printf("two inputs, coverage of the 95 %% band: %.3f, residual variance %.3f\n", share, residual_variance);
  // As above: standard error of the share about sqrt(0.05 * 0.95 / 150) = 0.018.
  EXPECT_GE(share, 0.895);
  EXPECT_LE(share, 0.99);
  EXPECT_NEAR(residual_variance, 1.0, 0.05);
}

// With premises that do not matter (both rules carry the same line) the model is a straight line, whose variance is
// known.
TEST(PredictionVariance, OfAStraightLineIsThatOfTheTextbook) {
  const std::vector<CurveRule> rules = {{0.8, 0.0, -1.0, 0.0, 0.25}, {0.8, 0.0, 1.0, 0.0, 0.25}};
  Model line = curve_model(Shape::gaussian, rules);
  line.order = 0;
  line.inputs[0].scale.half_range = 10.0;
  line.inputs[0].min = -10.0;
  line.inputs[0].max = 10.0;
  TrainingData data;
  for (int i = -10; i <= 10; ++i) {
    data.x.push_back(i);
    data.y.push_back(0.25);
  }
  // Consequent regressors: two strengths whose sum is 1. Textbook: (A^T A)^-1 of the 2x2 system by hand.
  double a11 = 0.0, a12 = 0.0, a22 = 0.0;
  std::vector<double> s(2);
  for (const double x : data.x) {
    firing_strengths(line, std::span(&x, 1), s);
    a11 += s[0] * s[0];
    a12 += s[0] * s[1];
    a22 += s[1] * s[1];
  }
  const auto variance = PredictionVariance::of(line, data);
  ASSERT_TRUE(variance);
  EXPECT_EQ(variance->effective_parameters(), 2);
  EXPECT_EQ(variance->degrees_of_freedom(), 19);
  for (const double x : {-10.0, -3.3, 0.0, 7.0}) {
    firing_strengths(line, std::span(&x, 1), s);
    const double expected = (a22 * s[0] * s[0] - 2.0 * a12 * s[0] * s[1] + a11 * s[1] * s[1]) / (a11 * a22 - a12 * a12);
    EXPECT_NEAR(variance->at(x, 4.0), 4.0 * expected, 1e-12);
  }
}

TEST(PredictionVariance, HoldsTheRunToRunVarianceOfTheMean) {
  const TrainingData data = simulate(1);
  const auto training = train_hybrid(test::grid(data, 3), data);
  const auto variance = PredictionVariance::of(training->model, data);
  ASSERT_TRUE(variance);
  for (const double t : {-30.0, 20.0, 70.0}) {
    EXPECT_GT(variance->at(t), kRunSigma * kRunSigma / kRuns);
    EXPECT_LT(variance->at(t), kRunSigma * kRunSigma / kRuns + kNoise * kNoise);
  }
}

TEST(PredictionVariance, RefusesWhatHasNoFiniteVariance) {
  TrainingData data = simulate(1);
  data.group_variance = std::numeric_limits<double>::infinity();
  EXPECT_EQ(PredictionVariance::of(truth(), data).error().where, "group_variance");
  const TrainingData few{{-30.0, 0.0, 30.0, 70.0}, {0.0, 1.0, 0.0, 1.0}, {}, {}, 0.0};
  EXPECT_EQ(PredictionVariance::of(truth(), few).error().where, "x");
}

}  // namespace
}  // namespace soak::anfis
