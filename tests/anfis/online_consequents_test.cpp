// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/online_consequents.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/random.h"

namespace soak::anfis {
namespace {

// Two inputs in odd units, a grid of 2 x 2 bells and Gaussians, first-order consequents with two gains dropped.
Model two_inputs(int order) {
  Model model;
  model.order = order;
  model.inputs = {{"temperature", {20.0, 50.0}, -30.0, 70.0, {bell(1.0, 2.0, -1.0), bell(1.0, 2.0, 1.0)}},
                  {"rate", {0.0, 4.0}, -4.0, 4.0, {gaussian(0.8, -1.0), gaussian(0.8, 1.0)}}};
  model.output = {100.0, 25.0};
  for (const int i : {0, 1}) {
    for (const int j : {0, 1}) model.rules.push_back({{i, j}, {0.0, 0.0}, 0.1 * (i - j), {}});
  }
  model.rules[1].dropped = {0};
  model.rules[2].dropped = {0, 1};
  if (order == 1) model.rules[0].gains = {0.5, -0.25};
  return model;
}

// wbar_i (u, 1) of the free consequents of two_inputs(), written out.
std::vector<double> plain_row(const Model& model, std::span<const double> x) {
  const double u = (x[0] - 20.0) / 50.0;
  const double v = x[1] / 4.0;
  std::array<double, 4> w{};
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    w[i] = degree(model.inputs[0].memberships[i / 2], u) * degree(model.inputs[1].memberships[i % 2], v);
    sum += w[i];
  }
  for (double& value : w) value /= sum;
  if (model.order == 0) return {w[0], w[1], w[2], w[3]};
  return {w[0] * u, w[0] * v, w[0], w[1] * v, w[1], w[2], w[3] * u, w[3] * v, w[3]};
}

std::vector<double> plain_consequents(const Model& model) {
  const auto& r = model.rules;
  if (model.order == 0) return {r[0].offset, r[1].offset, r[2].offset, r[3].offset};
  return {r[0].gains[0], r[0].gains[1], r[0].offset,   r[1].gains[1], r[1].offset,
          r[2].offset,   r[3].gains[0], r[3].gains[1], r[3].offset};
}

Eigen::VectorXd vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::array<double, 2> random_point(base::Random& random) {
  return {random.uniform(-30.0, 70.0), random.uniform(-4.0, 4.0)};
}

double some_system(std::span<const double> x) { return 100.0 + 20.0 * std::sin(0.03 * x[0]) + 0.2 * x[0] * x[1]; }

// Minimum of sum lambda^(N-i) (b_i - a_i^T X)^2 + (lambda^N / eta) ||X - X_0||^2, X_0 the consequents given.
TEST(OnlineConsequents, EqualsBatchLeastSquaresWithForgettingWeightsAroundTheGivenConsequents) {
  for (const int order : {0, 1}) {
    const Model model = two_inputs(order);
    const OnlineOptions options{.forgetting = 0.98, .initial_covariance = 10.0};
    auto online = OnlineConsequents::of(model, options);
    ASSERT_TRUE(online);
    const Eigen::VectorXd given = vector(plain_consequents(model));
    const int rows = 80;
    Eigen::MatrixXd information = std::pow(0.98, rows) / 10.0 * Eigen::MatrixXd::Identity(given.size(), given.size());
    Eigen::VectorXd right = information * given;
    base::Random random(4);
    for (int i = 0; i < rows; ++i) {
      const auto x = random_point(random);
      ASSERT_TRUE(online->update(x, some_system(x)));
      const Eigen::VectorXd a = vector(plain_row(model, x));
      const double weight = std::pow(0.98, rows - 1 - i);
      information += weight * a * a.transpose();
      right += weight * (some_system(x) - 100.0) / 25.0 * a;
    }
    const Eigen::VectorXd expected = information.llt().solve(right);
    const Eigen::VectorXd got = vector(plain_consequents(online->model()));
    // Rounding of S_0 = 10, about 1e-15, times the condition of the problem, at most 10 / (2 eigenvalues of S): 1e3.
    EXPECT_LT((got - expected).cwiseAbs().maxCoeff(), 1e-11) << order;
  }
}

TEST(OnlineConsequents, LearnsNothingButTheFreeConsequents) {
  Model model = two_inputs(1);
  auto online = OnlineConsequents::of(model);
  ASSERT_TRUE(online);
  base::Random random(6);
  for (int i = 0; i < 500; ++i) {
    const auto x = random_point(random);
    ASSERT_TRUE(online->update(x, some_system(x)));
  }
  EXPECT_TRUE(validate(online->model()));  // dropped gains are 0
  EXPECT_NE(online->model().rules, model.rules);
  Model learned = online->model();
  learned.rules = model.rules;
  EXPECT_EQ(learned, model);
}

// A system of the model's own structure whose consequents change sign after 1000 rows. With window 50 the old rows
// weigh 0.98^500 = 4e-5 of all 500 rows later; without forgetting they weigh 2/3, and a third of the old system is
// left.
TEST(OnlineConsequents, TracksASystemThatChanges) {
  Model before = two_inputs(1);
  Model after = before;
  for (std::size_t i = 0; i < 4; ++i) {
    before.rules[i].offset = 0.3 - 0.2 * static_cast<double>(i);
    after.rules[i].offset = -before.rules[i].offset;
    for (double& gain : after.rules[i].gains) gain = -gain;
  }
  const auto error_share = [&](double forgetting) {
    auto online = OnlineConsequents::of(two_inputs(1), {.forgetting = forgetting});
    base::Random random(8);
    for (int i = 0; i < 1500; ++i) {
      const auto x = random_point(random);
      EXPECT_TRUE(online->update(x, evaluate(i < 1000 ? before : after, x)));
    }
    double error = 0.0;
    double size = 0.0;
    for (int i = 0; i < 400; ++i) {
      const auto x = random_point(random);
      error += std::pow(evaluate(online->model(), x) - evaluate(after, x), 2);
      size += std::pow(evaluate(after, x) - after.output.centre, 2);
    }
    return std::sqrt(error / size);
  };
  EXPECT_LT(error_share(0.98), 3.0 * 2.0 * 4e-5);  // the change is twice the system; weights differ by row, hence 3
  EXPECT_NEAR(error_share(1.0), 2.0 * 2.0 / 3.0, 0.2);
}

TEST(OnlineConsequents, StaysFiniteAndValidOverAMillionRowsOfConstantInput) {
  const Model model = two_inputs(1);
  auto online = OnlineConsequents::of(model);
  ASSERT_TRUE(online);
  const std::array<double, 2> x = {-25.0, 3.0};
  for (int i = 0; i < 1'000'000; ++i) ASSERT_TRUE(online->update(x, 110.0));
  ASSERT_TRUE(validate(online->model()));
  // S has entries of 1e6, rounded to 1e-10; 1/(1 - 0.99) roundings and the half range of 25 make it 3e-7.
  EXPECT_NEAR(evaluate(online->model(), x), 110.0, 1e-6);
  // Other rows are learned at once, as their directions still have the variance eta.
  const std::array<double, 2> other = {65.0, -3.5};
  ASSERT_TRUE(online->update(other, 95.0));
  EXPECT_NEAR(evaluate(online->model(), other), 95.0, 1e-3);
}

TEST(OnlineConsequents, RefusesRowsThatTheModelSaysNothingAboutAndKeepsIt) {
  auto online = OnlineConsequents::of(two_inputs(1));
  ASSERT_TRUE(online);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array<double, 2> usual = {10.0, 1.0};
  ASSERT_TRUE(online->update(usual, 105.0));
  const Model before = online->model();
  struct Row {
    std::vector<double> x;
    double y;
    const char* where;
  };
  for (const Row& row :
       {Row{{10.0}, 1.0, "x"}, Row{{10.0, 1.0, 1.0}, 1.0, "x"}, Row{{nan, 1.0}, 1.0, "x[0]"},
        Row{{10.0, 4.1}, 1.0, "x[1]"}, Row{{10.0, -HUGE_VAL}, 1.0, "x[1]"}, Row{{10.0, 1.0}, nan, "y"},
        Row{{10.0, 1.0}, HUGE_VAL, "y"}, Row{{10.0, 1.0}, 1e107, "y"}, Row{{10.0, 1.0}, 1.7e308, "y"}}) {
    const auto status = online->update(row.x, row.y);
    ASSERT_FALSE(status) << row.where << row.y;
    EXPECT_EQ(status.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(status.error().where, row.where);
    EXPECT_EQ(online->model(), before);
  }
  EXPECT_TRUE(online->update(usual, 105.0));
}

TEST(OnlineConsequents, RefusesOptionsOutOfRangeAndInvalidModels) {
  for (const double forgetting : {0.0, -0.5, 1.01, std::numeric_limits<double>::quiet_NaN()}) {
    const auto online = OnlineConsequents::of(two_inputs(1), {.forgetting = forgetting});
    ASSERT_FALSE(online);
    EXPECT_EQ(online.error().where, "forgetting");
  }
  for (const double covariance : {0.0, 2e9, std::numeric_limits<double>::quiet_NaN()}) {
    const auto online = OnlineConsequents::of(two_inputs(1), {.initial_covariance = covariance});
    ASSERT_FALSE(online);
    EXPECT_EQ(online.error().where, "initial_covariance");
  }
  Model broken = two_inputs(1);
  broken.rules[0].premise[0] = 7;
  EXPECT_FALSE(OnlineConsequents::of(broken));
}

}  // namespace
}  // namespace soak::anfis
