// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/structure_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "anfis/linear/condensed_rows.h"
#include "base/random.h"
#include "curves.h"
#include "support.h"

namespace soak::anfis {
namespace {

TEST(StructureSearch, ChoosesTheFewestRulesWithinOneErrorOfThePairedDifference) {
  const auto problem = test::drift_problem(3, 8);
  const std::vector<int> fold = test::folds_by_group(problem.data, 4);
  const auto search = search_structure(problem.data, fold, {.learner = HybridOptions()});
  ASSERT_TRUE(search);
  ASSERT_GE(search->curve.size(), 4U);
  // The curve again, with folds, residuals and offsets by hand.
  std::vector<std::vector<double>> errors;
  for (const StructureSearchPoint& point : search->curve) {
    EXPECT_EQ(point.rules, point.memberships);
    errors.emplace_back();
    for (int f = 0; f < 4; ++f) {
      TrainingData train{{}, {}, {}, {}, problem.data.group_variance};
      for (std::size_t i = 0; i < fold.size(); ++i) {
        if (fold[i] != f) {
          train.x.push_back(problem.data.x[i]);
          train.y.push_back(problem.data.y[i]);
          train.weight.push_back(problem.data.weight[i]);
          train.group.push_back(problem.data.group[i]);
        }
      }
      const auto training = train_hybrid(test::grid(train, point.memberships), train);
      ASSERT_TRUE(training);
      double squares = 0.0;
      for (const int run : {f, f + 4}) {
        std::vector<double> r;
        for (std::size_t i = 0; i < fold.size(); ++i) {
          if (problem.data.group[i] == run) {
            r.push_back(problem.data.y[i] - evaluate(training->model, problem.data.x[i]));
          }
        }
        double mean = 0.0;
        for (const double v : r) mean += v / 21.0;
        for (const double v : r) squares += (v - mean) * (v - mean);
      }
      errors.back().push_back(std::sqrt(squares / 42.0));
    }
    const auto& e = errors.back();
    EXPECT_NEAR(point.mean_error, (e[0] + e[1] + e[2] + e[3]) / 4.0, 1e-12);
  }
  const auto mean = [](const std::vector<double>& e) { return (e[0] + e[1] + e[2] + e[3]) / 4.0; };
  const auto best =
      *std::min_element(errors.begin(), errors.end(), [&](const auto& a, const auto& b) { return mean(a) < mean(b); });
  int chosen = 0;
  for (std::size_t i = 0; i < errors.size() && chosen == 0; ++i) {
    double squares = 0.0;
    const double excess = mean(errors[i]) - mean(best);
    for (std::size_t f = 0; f < 4; ++f) squares += std::pow(errors[i][f] - best[f] - excess, 2);
    chosen = excess <= std::sqrt(squares / 3.0 / 4.0) ? search->curve[i].memberships : 0;
  }
  EXPECT_EQ(search->chosen, chosen);
  EXPECT_LE(search->chosen, search->best);
}

TEST(StructureSearch, AStraightLineNeedsNoMoreThanTwoRules) {
  base::Random random(21);
  TrainingData data;
  for (int run = 0; run < 6; ++run) {
    for (int i = 0; i <= 20; ++i) {
      data.x.push_back(5.0 * i);
      data.y.push_back(0.01 * i + 0.05 * run + 0.002 * random.gaussian());
      data.group.push_back(run);
    }
  }
  data.group_variance = 100.0;
  EXPECT_EQ(search_structure(data, test::folds_by_group(data, 6), {})->chosen, 2);
  EXPECT_EQ(search_structure(data, test::folds_by_group(data, 6), {.learner = HybridOptions()})->chosen, 2);
}

double three_waves(double x) { return 0.3 * std::sin(x * std::numbers::pi * 6.0 / 100.0); }

/// One pass over 21 temperatures; three periods of a sine, or a straight line. Noise 0.01.
TrainingData one_pass(bool waves, unsigned seed) {
  base::Random random(seed);
  TrainingData data;
  for (int i = 0; i <= 20; ++i) {
    data.x.push_back(5.0 * i);
    data.y.push_back((waves ? three_waves(data.x.back()) : 0.01 * i) + 0.01 * random.gaussian());
    data.weight.push_back(1e4);
  }
  return data;
}

TEST(StructureSearch, WithoutFoldsOnePassOverWavesGetsTheRulesThatTheyNeedAndALineFew) {
  const StructureSearchOptions options = {.learner = VariableProjectionOptions{.smoothness = 1e-7}};
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const TrainingData waves = one_pass(true, seed);
    const auto found = search_structure(waves, options);
    ASSERT_TRUE(found);
    const auto initial = grid_rules(waves, {.memberships = {found->memberships}});
    ASSERT_TRUE(initial);
    const auto training = train(*initial, waves, options.learner);
    ASSERT_TRUE(training);
    double squares = 0.0;
    for (const double x : waves.x) squares += std::pow(evaluate(training->model, x) - three_waves(x), 2) / 21.0;
    // Fitted values of p parameters err by 0.01 sqrt(p / 21), less than the noise; a wave that is not followed by 0.1.
    EXPECT_LT(std::sqrt(squares), 0.015) << seed << ": " << found->memberships << " rules";
    const auto line = search_structure(one_pass(false, seed), options);
    ASSERT_TRUE(line);
    EXPECT_LE(line->memberships, 3) << seed;
    // Of a right model the expected error of the fitted values is near the number of rows, plus the parameters.
    EXPECT_LT(found->expected_error, 3.0 * 21.0);
  }
}

TEST(StructureSearch, WithoutFoldsRefusesWhatLeavesNoCandidate) {
  const auto search = search_structure(one_pass(true, 1), {.min_memberships = 5, .max_memberships = 4});
  ASSERT_FALSE(search);
  EXPECT_EQ(search.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(search.error().where, "min_memberships, max_memberships");
}

TEST(StructureSearch, LeavesAQuarterOfTheResolvedInputsOver) {
  const auto problem = test::drift_problem(3, 4);
  EXPECT_EQ(resolved_values(problem.data), 21);
  const auto search = search_structure(problem.data, test::folds_by_group(problem.data, 4), {});
  ASSERT_TRUE(search);
  EXPECT_EQ(search->curve.front().rules, 2);
  EXPECT_EQ(search->curve.back().rules, 7);  // 14 consequents of at most 15
}

// y = sin(3 u) + v with noise 0.01 on a grid of 13 x 13 points: held-out errors of twice the noise leave room for the
// 24 parameters of the least grid, sqrt(1 + 24/127) = 1.09, and for misfit.
TEST(StructureSearch, OfTwoInputsTriesGridsOfEqualSides) {
  base::Random random(5);
  TrainingData data;
  data.inputs = 2;
  std::vector<int> fold;
  for (int i = 0; i < 169; ++i) {
    const double u = -1.0 + i / 13 / 6.0, v = -1.0 + i % 13 / 6.0;
    data.x.insert(data.x.end(), {u, v});
    data.y.push_back(std::sin(3.0 * u) + v + 0.01 * random.gaussian());
    fold.push_back(i % 4);
  }
  StructureSearchOptions options;
  options.max_memberships = 4;
  const auto search = search_structure(data, fold, options);
  ASSERT_TRUE(search) << search.error().message;
  ASSERT_EQ(search->curve.size(), 3U);
  for (const StructureSearchPoint& point : search->curve) {
    EXPECT_EQ(point.rules, point.memberships * point.memberships);
  }
  EXPECT_GE(search->chosen, 2);
  EXPECT_LT(search->curve[static_cast<std::size_t>(search->chosen - 2)].mean_error, 0.02);
}

TEST(StructureSearch, JudgesOnCondensedRowsAsOnAll) {
  TrainingData data = test::drift_problem(2, 6).data;
  for (double& x : data.x) x = 5.0 * std::round(x / 5.0);
  const auto condensed = [](const TrainingData& rows) { return condense(rows, 0.0, [](double) { return 0.0; }); };
  StructureSearchOptions options;
  options.rule_base.shape = Shape::gaussian;
  options.learner = test::quick_curve_learner();
  const std::vector<int> fold = test::folds_by_group(data, 3);
  const auto judged = judge_structures(data, fold, options, condensed);
  ASSERT_TRUE(judged) << judged.error().message;
  const StructureSearch of_few = choose_structure(*judged, options.max_memberships);
  const StructureSearch of_all = search_structure(data, fold, options).value();
  ASSERT_EQ(of_few.curve.size(), of_all.curve.size());
  for (std::size_t i = 0; i < of_all.curve.size(); ++i) {
    EXPECT_NEAR(of_few.curve[i].mean_error, of_all.curve[i].mean_error, 0.01 * of_all.curve[i].mean_error) << i + 2;
  }
}

TEST(StructureSearch, AGroupThatIsNoJudgeIsLearnedFromInEveryFold) {
  const TrainingData data = test::drift_problem(2, 5).data;
  const auto judged_with = [](const TrainingData& rows, const std::vector<int>& fold) {
    return judge_structures(rows, fold, {.learner = test::quick_curve_learner()},
                            [](const TrainingData& all) { return base::Result<TrainingData>(all); })
        .value();
  };
  std::vector<int> fold = test::folds_by_group(data, 5);
  std::vector<bool> others;
  for (int& f : fold) {
    others.push_back(f != 4);
    if (f == 4) f = kNoJudge;
  }
  const auto with = judged_with(data, fold);
  const TrainingData four = select_rows(data, others);
  const auto without = judged_with(four, test::folds_by_group(four, 4));
  ASSERT_EQ(with.size(), without.size());
  for (std::size_t i = 0; i < with.size(); ++i) {
    ASSERT_EQ(with[i].errors.size(), 4U);
    for (std::size_t group = 0; group < 4; ++group) {
      EXPECT_EQ(with[i].errors[group].group, without[i].errors[group].group);
      EXPECT_NE(with[i].errors[group].squares, without[i].errors[group].squares);
    }
  }
}

TEST(StructureSearch, AGroupThatIsLeftOutHasNoSayInTheChoice) {
  // The second candidate is far better on the last group, and as good or as bad on the others.
  const auto candidate = [](int memberships, std::vector<double> squares) {
    JudgedCandidate judged{memberships, {}, {}};
    for (int group = 0; group < 4; ++group) {
      judged.errors.push_back({group, group % 3, 1.0, squares[static_cast<std::size_t>(group)]});
    }
    return judged;
  };
  const std::vector<JudgedCandidate> few = {candidate(2, {1.0, 1.1, 0.9, 900.0}), candidate(3, {4.0, 4.1, 3.9, 1.0})};
  EXPECT_EQ(choose_structure(few, 10, 3).chosen, 2);
  const std::vector<JudgedCandidate> many = {candidate(2, {81.0, 82.0, 80.0, 1.0}),
                                             candidate(3, {4.0, 4.1, 3.9, 900.0})};
  EXPECT_EQ(choose_structure(many, 10, 3).chosen, 3);
  EXPECT_EQ(choose_structure(many, 2, 3).chosen, 2);  // more than are carried
}

TEST(StructureSearch, RefusesFoldsThatCannotJudge) {
  const auto problem = test::drift_problem(3, 4);
  const auto where_of = [&](const std::vector<int>& fold, const StructureSearchOptions& options = {}) {
    const auto search = search_structure(problem.data, fold, options);
    return search ? std::string("accepted") : search.error().where;
  };
  EXPECT_EQ(where_of({1, 2}), "fold");
  EXPECT_EQ(where_of(std::vector<int>(problem.data.rows(), 1)), "fold");
  std::vector<int> split = test::folds_by_group(problem.data, 2);
  split[0] = 1 - split[0];
  EXPECT_EQ(where_of(split), "fold");
  StructureSearchOptions none;
  none.min_memberships = 9;
  EXPECT_EQ(where_of(test::folds_by_group(problem.data, 2), none), "min_memberships, max_memberships");
  StructureSearchOptions wrong;
  wrong.learner = HybridOptions{.epochs = 0};
  EXPECT_EQ(where_of(test::folds_by_group(problem.data, 2), wrong), "epochs");
  wrong.learner = VariableProjectionOptions{.evaluations = 0};
  EXPECT_EQ(where_of(test::folds_by_group(problem.data, 2), wrong), "evaluations");
  StructureSearchOptions shape;
  shape.rule_base.order = 2;
  EXPECT_EQ(where_of(test::folds_by_group(problem.data, 2), shape), "order");
}

}  // namespace
}  // namespace soak::anfis
