// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/rule_base.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anfis/model/one_input.h"
#include "anfis/train/learner.h"
#include "sample_models.h"
#include "support.h"

namespace soak::anfis {
namespace {

// Two inputs over [0, 30] and [-4, -1].
TrainingData corners() {
  TrainingData data{{0.0, -4.0, 30.0, -1.0, 10.0, -2.0}, {1.0, 5.0, 2.0}};
  data.inputs = 2;
  return data;
}

// [Jang93 §V]: centres equally spaced over the range, a = range / (2 (n - 1)), b = 2.
TEST(GridRules, AreThoseOfThePublishedPartition) {
  const auto model = grid_rules(corners(), {.memberships = {4, 2}, .scale = false});
  ASSERT_TRUE(model);
  ASSERT_EQ(model->inputs[0].memberships.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(model->inputs[0].memberships[k], bell(5.0, 2.0, 10.0 * static_cast<double>(k)));
  }
  EXPECT_EQ(model->inputs[1].memberships[0], bell(1.5, 2.0, -4.0));
  EXPECT_EQ(model->inputs[1].memberships[1], bell(1.5, 2.0, -1.0));
  EXPECT_EQ(model->output, Scale());
  EXPECT_EQ(model->inputs[0].min, 0.0);
  EXPECT_EQ(model->inputs[1].max, -1.0);
}

TEST(GridRules, AreTheSamePartitionInScaledUnits) {
  const auto model = grid_rules(corners(), {.memberships = {4, 2}});
  ASSERT_TRUE(model);
  EXPECT_EQ(model->inputs[0].scale, (Scale{15.0, 15.0}));
  EXPECT_EQ(model->inputs[1].scale, (Scale{-2.5, 1.5}));
  EXPECT_EQ(model->output, (Scale{3.0, 2.0}));
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& p = model->inputs[0].memberships[k].parameters;
    EXPECT_NEAR(p[0], 1.0 / 3.0, 1e-15);
    EXPECT_NEAR(p[2], -1.0 + 2.0 / 3.0 * static_cast<double>(k), 1e-15);
  }
}

TEST(GridRules, NeighboursCrossAtOneHalf) {
  for (const Shape shape : kShapes) {
    const auto model = grid_rules(corners(), {.memberships = {5, 3}, .shape = shape});
    ASSERT_TRUE(model);
    for (const Input& input : model->inputs) {
      for (std::size_t k = 1; k < input.memberships.size(); ++k) {
        const Membership &a = input.memberships[k - 1], &b = input.memberships[k];
        EXPECT_EQ(a.shape, shape);
        const double middle = 0.5 * (centre(a) + centre(b));
        EXPECT_NEAR(degree(a, middle), 0.5, 1e-14) << name(shape);
        EXPECT_NEAR(degree(b, middle), 0.5, 1e-14) << name(shape);
      }
      EXPECT_NEAR(centre(input.memberships.front()), -1.0, 1e-15);
      EXPECT_NEAR(centre(input.memberships.back()), 1.0, 1e-15);
    }
  }
}

TEST(GridRules, TrianglesReachToTheirNeighboursPeaks) {
  const auto model = grid_rules(corners(), {.memberships = {3, 3}, .shape = Shape::triangle});
  const auto& memberships = model->inputs[0].memberships;
  EXPECT_NEAR(memberships[1].parameters[0], memberships[0].parameters[1], 1e-15);
  EXPECT_NEAR(memberships[1].parameters[2], memberships[2].parameters[1], 1e-15);
  const auto trapezoids = grid_rules(corners(), {.memberships = {3, 3}, .shape = Shape::trapezoid});
  const auto& p = trapezoids->inputs[0].memberships[1].parameters;
  EXPECT_NEAR(p[2] - p[1], 1.0 / 3.0, 1e-15);  // a third of the spacing
}

TEST(GridRules, TheFirstInputVariesSlowest) {
  const auto model = grid_rules(corners(), {.memberships = {3, 2}, .order = 0, .t_norm = TNorm::minimum});
  ASSERT_TRUE(model);
  ASSERT_EQ(model->rules.size(), 6U);
  for (int i = 0; i < 6; ++i) {
    const Rule& rule = model->rules[static_cast<std::size_t>(i)];
    EXPECT_EQ(rule.premise, (std::vector<int>{i / 2, i % 2}));
    EXPECT_EQ(rule.gains, (std::vector<double>{0.0, 0.0}));
    EXPECT_EQ(rule.offset, 0.0);
  }
  EXPECT_EQ(model->order, 0);
  EXPECT_EQ(model->t_norm, TNorm::minimum);
}

TEST(GridRules, OneNumberCountsForEveryInput) {
  EXPECT_EQ(grid_rules(corners(), {.memberships = {5}})->rules.size(), 25U);
}

TEST(GridRules, TooManyAreRefused) {
  TrainingData data;
  data.inputs = 10;
  for (int i = 0; i < 20; ++i) data.x.push_back(i / 10);
  data.y = {0.0, 1.0};
  const auto model = grid_rules(data, {.memberships = {5}});
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(model.error().where, "memberships");
  EXPECT_TRUE(grid_rules(data, {.memberships = {2}}));
}

std::string refused_grid_option(void (*change)(RuleBaseOptions&)) {
  RuleBaseOptions options{.memberships = {3}};
  change(options);
  const auto model = grid_rules(corners(), options);
  return model ? std::string("accepted") : model.error().where;
}

TEST(GridRules, RefuseOptionsOutOfRangeByName) {
  EXPECT_EQ(refused_grid_option([](auto&) {}), "accepted");
  EXPECT_EQ(refused_grid_option([](auto& o) { o.order = 2; }), "order");
  EXPECT_EQ(refused_grid_option([](auto& o) { o.order = -1; }), "order");
  EXPECT_EQ(refused_grid_option([](auto& o) { o.memberships = {1}; }), "memberships");
  EXPECT_EQ(refused_grid_option([](auto& o) { o.memberships = {257}; }), "memberships");
  EXPECT_EQ(refused_grid_option([](auto& o) { o.memberships = {3, 3, 3}; }), "memberships");
  EXPECT_EQ(refused_grid_option([](auto& o) { o.memberships = {}; }), "memberships");
}

Eigen::MatrixXd column(std::initializer_list<double> values) {
  Eigen::MatrixXd m(static_cast<Eigen::Index>(values.size()), 1);
  std::copy(values.begin(), values.end(), m.data());
  return m;
}

TEST(ScatterRules, OfOneInputStandInRisingOrder) {
  const TrainingData data{{0.0, 50.0, 100.0}, {0.0, 1.0, 4.0}};
  const auto model =
      scatter_rules(data, column({80.0, 10.0, 40.0}), column({5.0, 10.0, 20.0}), {.shape = Shape::gaussian});
  ASSERT_TRUE(model);
  ASSERT_TRUE(validate_curve(*model));
  const auto rules = curve_rules(*model);
  ASSERT_EQ(rules.size(), 3U);
  EXPECT_NEAR(rules[0].centre, -0.8, 1e-15);
  EXPECT_NEAR(rules[1].centre, -0.2, 1e-15);
  EXPECT_NEAR(rules[2].centre, 0.6, 1e-15);
  EXPECT_NEAR(rules[0].width, 0.2, 1e-15);
  EXPECT_NEAR(rules[1].width, 0.4, 1e-15);
  EXPECT_NEAR(rules[2].width, 0.1, 1e-15);
}

TEST(ScatterRules, HaveMembershipsOfTheirOwnInTheOrderGiven) {
  Eigen::MatrixXd centres(2, 2), widths(2, 2);
  centres << 20.0, -3.0, 10.0, -2.0;
  widths << 3.0, 0.5, 6.0, 0.25;
  const auto model = scatter_rules(corners(), centres, widths, {.shape = Shape::gaussian, .scale = false});
  ASSERT_TRUE(model);
  EXPECT_EQ(model->rules[0].premise, (std::vector<int>{0, 0}));
  EXPECT_EQ(model->rules[1].premise, (std::vector<int>{1, 1}));
  EXPECT_NEAR(model->inputs[0].memberships[0].parameters[0], 3.0, 1e-14);
  EXPECT_EQ(model->inputs[0].memberships[1].parameters[1], 10.0);
  EXPECT_EQ(model->inputs[1].memberships[0].parameters[1], -3.0);
}

// The half width of a Gaussian is sqrt(2 ln 2) standard deviations.
TEST(ScatterRules, OfEveryShapeAreAsWideAsTheGaussian) {
  const TrainingData data{{0.0, 50.0, 100.0}, {0.0, 1.0, 4.0}};
  for (const Shape shape : kShapes) {
    const auto model =
        scatter_rules(data, column({50.0, 70.0}), column({10.0, 10.0}), {.shape = shape, .scale = false});
    ASSERT_TRUE(model) << name(shape);
    EXPECT_NEAR(degree(model->inputs[0].memberships[0], 50.0 + 10.0 * std::sqrt(2.0 * std::log(2.0))), 0.5, 1e-14);
  }
}

TEST(ScatterRules, AreRefusedWhereCentresOrWidthsAreNone) {
  const TrainingData data{{0.0, 50.0, 100.0}, {0.0, 1.0, 4.0}};
  const auto where = [&](const Eigen::MatrixXd& centres, const Eigen::MatrixXd& widths) {
    const auto model = scatter_rules(data, centres, widths, {});
    return model ? std::string("accepted") : model.error().where;
  };
  EXPECT_EQ(where(column({1.0, 2.0}), column({1.0, 2.0})), "accepted");
  EXPECT_EQ(where(column({}), column({})), "centres");
  EXPECT_EQ(where(column({1.0, std::nan("")}), column({1.0, 2.0})), "centres");
  EXPECT_EQ(where(column({1.0, 2.0}), column({1.0, 0.0})), "widths");
  EXPECT_EQ(where(column({1.0, 2.0}), column({1.0})), "widths");
  EXPECT_EQ(where(Eigen::MatrixXd::Ones(2, 2), Eigen::MatrixXd::Ones(2, 2)), "centres");
}

// Rules written by hand: every shape, kAny, a membership that two rules share, a dropped gain.
TEST(RuleBase, OfTheUserIsTrained) {
  const test::Sample sample = test::grid_sample(Shape::bell, TNorm::product, 1);
  Model model = sample.model;
  model.inputs[0].memberships = {{Shape::two_sided_gaussian, {0.5, -0.8, 0.6, -0.5}}, bell(0.6, 2.0, 0.4)};
  model.inputs[1].memberships = {{Shape::trapezoid, {-2.0, -1.0, 0.0, 1.5}}, gaussian(0.6, 0.8)};
  model.rules = {{{0, 0}, {0.0, 0.0}, 0.0, {}}, {{0, 1}, {0.0, 0.0}, 0.0, {1}}, {{1, kAny}, {0.0, 0.0}, 0.0, {}}};
  const auto training = train_hybrid(model, sample.data);
  ASSERT_TRUE(training) << training.error().message << training.error().where;
  EXPECT_TRUE(validate(training->model));
  EXPECT_EQ(training->model.rules[1].premise, model.rules[1].premise);
  EXPECT_EQ(training->model.rules[1].gains[1], 0.0);
  const auto& history = training->summary.history;
  EXPECT_LT(training->summary.train_rmse, 0.99 * history.front().train_rmse);
  EXPECT_NEAR(shape_rmse(sample.data, training->model), training->summary.train_rmse, 1e-12);
}

}  // namespace
}  // namespace soak::anfis
