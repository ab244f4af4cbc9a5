// SPDX-License-Identifier: Apache-2.0
#include "ten_inputs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <string>

#include "anfis/select/fuzzy_ols.h"
#include "anfis/train/learner.h"
#include "fuzzy_support.h"
#include "tests/long_tests.h"

namespace soak::anfis {
namespace {

using test::TenInputs;

void expect_compact_and_near_the_noise(const TenInputs& problem, const std::vector<int>& bending,
                                       const std::string& label) {
  FuzzyOlsOptions quick = test::quick_options({6, 12});
  quick.clustering.iterations = 25;
  const auto start = fuzzy_ols(problem.train, quick);
  ASSERT_TRUE(start) << start.error().message;
  HybridOptions options;
  options.epochs = 100;
  const auto trained = train_hybrid(start->model, problem.train, options);
  ASSERT_TRUE(trained) << trained.error().message;
  const double untrained = shape_rmse(problem.test, start->model) / problem.noise;
  const double error = shape_rmse(problem.test, trained->model) / problem.noise;
  std::cout << label << ": " << start->report.one_line() << "\n"
            << "  held-out RMSE / noise: " << untrained << " from fuzzy_ols, " << error << " after hybrid learning; "
            << trained->model.rules.size() << " rules, " << consequent_count(trained->model) << " consequents, "
            << premise_count(trained->model) << " premise parameters\n";
  EXPECT_LE(trained->model.rules.size(), 20U);
  for (const int input : bending) EXPECT_TRUE(std::ranges::binary_search(start->report.compact.antecedents, input));
  EXPECT_LE(start->report.compact.antecedents.size(), 5U);
  // No model whatever is better on fresh rows than their noise: the best that can be fitted lies above 1.
  EXPECT_LE(error, 1.10);
}

TEST(TenInputs, FriedmansFunctionNeedsAtMostTwentyRules) {
  expect_compact_and_near_the_noise(test::friedman(), {0, 1, 2}, "Friedman");
}

TEST(TenInputs, SaturationsOfCorrelatedInputsNeedAtMostTwentyRules) {
  SOAK_LONG_TEST();
  // The product needs only one of its factors as antecedent: it is linear in the other.
  expect_compact_and_near_the_noise(test::saturations(), {0, 7}, "Saturations");
}

}  // namespace
}  // namespace soak::anfis
