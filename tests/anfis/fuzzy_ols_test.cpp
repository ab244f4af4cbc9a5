// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/fuzzy_ols.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "anfis/train/learner.h"
#include "base/random.h"
#include "fuzzy_support.h"

namespace soak::anfis {
namespace {

using test::one_bent_input;
using test::quick_options;
using test::Square;

TEST(FuzzyOls, KeepsWhatBendsAsAntecedentAndDropsWhatDoesNotMatter) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto result = fuzzy_ols(one_bent_input(seed), quick_options({4}));
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->report.compact.antecedents, std::vector<int>{0}) << "seed " << seed;
    ASSERT_TRUE(validate(result->model));
    for (std::size_t i = 0; i < result->model.rules.size(); ++i) {
      const Rule& rule = result->model.rules[i];
      EXPECT_NE(rule.premise[0], kAny);
      for (std::size_t j = 1; j < 4; ++j) EXPECT_EQ(rule.premise[j], kAny);
      // Input 1 counts everywhere; 2 and 3 explain nothing but noise.
      EXPECT_FALSE(std::ranges::binary_search(rule.dropped, 1)) << "seed " << seed << " rule " << i;
      EXPECT_TRUE(std::ranges::binary_search(rule.dropped, 2)) << "seed " << seed << " rule " << i;
      EXPECT_TRUE(std::ranges::binary_search(rule.dropped, 3)) << "seed " << seed << " rule " << i;
    }
  }
}

TEST(FuzzyOls, ReportsWhatItDid) {
  const TrainingData data = one_bent_input(3);
  const auto result = fuzzy_ols(data, quick_options({2, 4, 6}));
  ASSERT_TRUE(result);
  const FuzzyOlsReport& report = result->report;
  ASSERT_EQ(report.candidates.size(), 3U);
  for (const FuzzyOlsCandidate& candidate : report.candidates) {
    ASSERT_EQ(candidate.elimination.size(), 4U);
    EXPECT_EQ(std::set<int>(candidate.ranking.begin(), candidate.ranking.end()).size(), 4U);
    for (std::size_t step = 0; step < 4; ++step) {
      EXPECT_EQ(candidate.elimination[step].antecedents.size(), 4 - step);
      EXPECT_GE(candidate.log_separability[step], 0.0);
    }
    EXPECT_EQ(candidate.elimination[3].antecedents[0], candidate.ranking[3]);
  }
  const FuzzyOlsCandidate& chosen = report.candidates[report.chosen];
  EXPECT_EQ(report.full.antecedents.size(), 4U);
  EXPECT_EQ(report.full.held_out_rmse, chosen.elimination[0].held_out_rmse);
  EXPECT_EQ(report.compact_antecedents.held_out_rmse, chosen.elimination[chosen.chosen].held_out_rmse);
  EXPECT_EQ(report.full.consequents, 5 * report.full.rules);
  EXPECT_LT(report.compact.consequents, report.full.consequents);
  EXPECT_EQ(report.consequents.size(), result->model.rules.size());
  for (std::size_t i = 0; i < report.consequents.size(); ++i) {
    EXPECT_EQ(report.consequents[i].kept + result->model.rules[i].dropped.size(), 4U);
  }
  EXPECT_NEAR(report.train_rmse, shape_rmse(data, result->model), 1e-15);
  EXPECT_NE(report.one_line().find("rules"), std::string::npos);
}

TEST(FuzzyOls, ConsequentsSolveTheNormalEquationsOfAllRulesTogether) {
  TrainingData data = one_bent_input(5);
  base::Random random(6);
  for (std::size_t k = 0; k < data.rows(); ++k) data.weight.push_back(random.uniform(0.5, 2.0));
  const auto result = fuzzy_ols(data, quick_options({3}));
  ASSERT_TRUE(result);
  const Model& model = result->model;
  const std::vector<double> r = residuals(data, model);
  std::vector<double> wbar(model.rules.size());
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    std::array<double, 5> sums{};  // of weight r wbar_i u_j, then of weight r wbar_i
    for (std::size_t k = 0; k < data.rows(); ++k) {
      firing_strengths(model, data.row(k), wbar);
      const double term = data.weight[k] * r[k] * wbar[i];
      for (std::size_t j = 0; j < 4; ++j) sums[j] += term * model.inputs[j].scale.scaled(data.row(k)[j]);
      sums[4] += term;
    }
    for (int j = 0; j < 5; ++j) {
      if (j < 4 && std::ranges::binary_search(model.rules[i].dropped, j)) continue;
      EXPECT_NEAR(sums[static_cast<std::size_t>(j)], 0.0, 1e-9) << "rule " << i << " term " << j;
    }
  }
}

TEST(FuzzyOls, IsAWarmStartForHybridLearning) {
  const TrainingData data = one_bent_input(7);
  const auto result = fuzzy_ols(data, quick_options({4}));
  ASSERT_TRUE(result);
  HybridOptions options;
  options.epochs = 1;
  options.limits = PremiseLimits::none;
  const auto same = train_hybrid(result->model, data, options);
  ASSERT_TRUE(same) << same.error().message;
  // Nothing moves in one epoch, and the consequents are already those of least squares.
  EXPECT_NEAR(same->summary.train_rmse, result->report.train_rmse, 1e-9);
  options.epochs = 60;
  const auto trained = train_hybrid(result->model, data, options);
  ASSERT_TRUE(trained);
  EXPECT_LT(trained->summary.train_rmse, result->report.train_rmse);
  for (std::size_t i = 0; i < trained->model.rules.size(); ++i) {
    EXPECT_EQ(trained->model.rules[i].dropped, result->model.rules[i].dropped);
    EXPECT_EQ(trained->model.rules[i].premise, result->model.rules[i].premise);
  }
}

TEST(FuzzyOls, GroupsWithFreeOffsetsKeepTheShape) {
  TrainingData data = one_bent_input(8, 600);
  data.group_variance = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < data.rows(); ++k) {
    data.group.push_back(static_cast<int>(k % 40));
    data.y[k] += 20.0 * static_cast<double>(k % 40);
  }
  const auto result = fuzzy_ols(data, quick_options({6}));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.compact.antecedents, std::vector<int>{0});
  // The truth bends by sin(3 x): six local lines follow it to about its curvature times the squared spacing over 16,
  // 9 (1/3)^2 / 16 = 0.06, beside noise 0.05 and offsets of up to 780.
  EXPECT_LT(shape_rmse(data, result->model), std::hypot(0.06, 0.05) * 1.2);
}

TEST(FuzzyOls, TheSameArgumentsGiveTheSameBits) {
  const TrainingData data = one_bent_input(9);
  const auto a = fuzzy_ols(data, quick_options({2, 4}));
  const auto b = fuzzy_ols(data, quick_options({2, 4}));
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->model, b->model);
  EXPECT_EQ(a->report.compact.held_out_rmse, b->report.compact.held_out_rmse);
}

TEST(FuzzyOls, OneInputNeedsNoElimination) {
  TrainingData data;
  for (int k = 0; k < 120; ++k) {
    data.x.push_back(k);
    data.y.push_back(std::abs(k - 60.0));
  }
  const auto result = fuzzy_ols(data, quick_options({2, 4}));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.compact.antecedents, std::vector<int>{0});
  EXPECT_GT(result->report.consequents[0].ratios[0], 0.0);
  EXPECT_LT(result->report.train_rmse, 2.0);
}

TEST(FuzzyOls, AConstantOutputBecomesAConstantModel) {
  TrainingData data = one_bent_input(10, 200);
  std::ranges::fill(data.y, -3.5);
  const auto result = fuzzy_ols(data, quick_options({2, 4}));
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->report.candidates[result->report.chosen].clusters, 2);
  EXPECT_NEAR(evaluate(result->model, data.row(17)), -3.5, 1e-12);
}

TEST(FuzzyOls, RefusesDataThatCannotCarryTheLeastNumberOfRules) {
  // 3/4 of 30 rows are fitted (22 after rounding), at most 3/4 consequents each: 16 of them are three rules of five.
  EXPECT_TRUE(fuzzy_ols(one_bent_input(1, 30), quick_options({3, 20})));
  const auto refused = fuzzy_ols(one_bent_input(1, 30), quick_options({4}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "x");
  TrainingData data = one_bent_input(1, 50);
  data.x[7] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(fuzzy_ols(data, {}).error().where, "row 1");
  data = one_bent_input(1, 50);
  for (std::size_t k = 0; k < 50; ++k) data.x[4 * k + 2] = 1.0;
  EXPECT_FALSE(fuzzy_ols(data, {}));
  for (double& y : data.y) y *= 1e200;
  EXPECT_FALSE(fuzzy_ols(data, {}));
  EXPECT_FALSE(fuzzy_ols(TrainingData{}, {}));
}

TEST(FuzzyOls, NumbersBeyondLeastSquaresAreRefused) {
  TrainingData data = one_bent_input(1, 100);
  for (double& y : data.y) y *= 1e200;
  const auto refused = fuzzy_ols(data, quick_options({2}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
}

TEST(FuzzyOls, OptionsOutOfRangeAreNamed) {
  const auto where = [](auto change) {
    FuzzyOlsOptions options;
    change(options);
    const auto status = options.validate();
    return status ? std::string("accepted") : status.error().where;
  };
  EXPECT_TRUE(FuzzyOlsOptions{}.validate());
  EXPECT_EQ(where([](auto& o) { o.clusters = {}; }), "clusters");
  EXPECT_EQ(where([](auto& o) { o.clusters = {4, 4}; }), "clusters");
  EXPECT_EQ(where([](auto& o) { o.clusters = {0, 4}; }), "clusters");
  EXPECT_EQ(where([](auto& o) { o.clusters = {4, 257}; }), "clusters");
  EXPECT_EQ(where([](auto& o) { o.held_out_share = 0.0; }), "held_out_share");
  EXPECT_EQ(where([](auto& o) { o.held_out_share = 0.6; }), "held_out_share");
  EXPECT_EQ(where([](auto& o) { o.consequent_threshold = 1.0; }), "consequent_threshold");
  EXPECT_EQ(where([](auto& o) { o.clustering.starts = 0; }), "starts");
}

// Held-out errors that overflow judge nothing: this once read beyond the list of candidates.
TEST(FuzzyOls, RefusesNumbersWhoseErrorsOverflow) {
  TrainingData data;
  for (int k = 0; k < 44; ++k) {
    data.x.push_back(k == 2 ? 1e6 : k / 43.0);
    data.y.push_back(1e100 * std::sin(1.7 * k));
    data.weight.push_back(1e100);
  }
  FuzzyOlsOptions options;
  options.clusters = {1, 2};
  const auto result = fuzzy_ols(data, options);
  if (result) {
    EXPECT_TRUE(validate(result->model));
    EXPECT_TRUE(std::isfinite(result->report.train_rmse));
  } else {
    EXPECT_EQ(result.error().kind, base::ErrorKind::bad_input);
  }
}

}  // namespace
}  // namespace soak::anfis
