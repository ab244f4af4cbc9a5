// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/group_deletion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "anfis/select/structure_search.h"
#include "anfis/train/learner.h"
#include "curves.h"
#include "support.h"

namespace soak::anfis {
namespace {

double flat(double) { return 0.0; }

/// Runs at exactly the same temperatures.
TrainingData shared_temperatures(unsigned seed, int runs) {
  TrainingData data = test::drift_problem(seed, runs).data;
  for (double& x : data.x) x = 5.0 * std::round(x / 5.0);
  return data;
}

std::vector<bool> rows_of(const TrainingData& data, int group) {
  std::vector<bool> flags;
  for (const int g : data.group) flags.push_back(g == group);
  return flags;
}

TEST(GroupDeletion, TellsWhatATrainingWithoutTheGroupWouldErrOnIt) {
  constexpr int kRuns = 8;
  double stated = 0.0, retrained = 0.0, seen = 0.0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const TrainingData data = shared_temperatures(seed, kRuns);
    const CondensedRows condensed = condense(data, 0.0, flat).value();
    const Model model = test::learn_curve(condensed.rows, 5, Shape::gaussian);
    const auto errors = deleted_group_errors(model, condensed, test::curve_learner().smoothness);
    ASSERT_TRUE(errors) << errors.error().message;
    ASSERT_EQ(errors->size(), static_cast<std::size_t>(kRuns));
    for (int run = 0; run < kRuns; ++run) {
      std::vector<bool> others = rows_of(data, run);
      const TrainingData held_out = select_rows(data, others);
      others.flip();
      const auto without = train_variable_projection(model, select_rows(data, others), test::curve_learner());
      const double expected = shape_rmse(held_out, without->model);
      EXPECT_NEAR(errors->at(static_cast<std::size_t>(run)), expected, 0.1 * expected) << seed << ' ' << run;
      stated += errors->at(static_cast<std::size_t>(run));
      retrained += expected;
      seen += shape_rmse(held_out, model);
    }
  }
  // Most of what learning without the group costs is in it.
  EXPECT_NEAR(stated - seen, retrained - seen, 0.2 * (retrained - seen));
}

TEST(GroupDeletion, JudgesARunByTheOthersWhereItAloneHasBeen) {
  // Three runs end at 20 °C, the fourth goes on: the others cannot know the curve there, and many rules least of all.
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const TrainingData all = shared_temperatures(seed, 4);
    std::vector<bool> kept;
    for (std::size_t i = 0; i < all.rows(); ++i) kept.push_back(all.group[i] == 3 || all.x[i] <= 20.0);
    const TrainingData data = select_rows(all, kept);
    std::vector<bool> last = rows_of(data, 3);
    const TrainingData held_out = select_rows(data, last);
    last.flip();
    const TrainingData others = select_rows(data, last);
    const CondensedRows condensed = condense(data, 0.0, flat).value();
    const Model model = test::learn_curve(condensed.rows, 5, Shape::gaussian);
    const double stated = deleted_group_errors(model, condensed, test::curve_learner().smoothness)->at(3);
    const auto without = train_variable_projection(model, others, test::curve_learner());
    ASSERT_TRUE(without);
    const double retrained = shape_rmse(held_out, without->model);
    // One step from afar is coarse, but of the right size; what all groups together leave there is far smaller.
    EXPECT_GT(stated, 0.25 * retrained) << seed;
    EXPECT_GT(stated, 10.0 * shape_rmse(held_out, model)) << seed;
  }
}

TEST(GroupDeletion, NeedsAnotherGroup) {
  const TrainingData one = shared_temperatures(1, 1);
  const CondensedRows condensed = condense(one, 0.0, flat).value();
  const Model model = test::learn_curve(condensed.rows, 4, Shape::bell);
  EXPECT_EQ(deleted_group_errors(model, condensed, 1e-7).error().where, "group");
}

TEST(GroupDeletion, FindsStructuresThatErrAsTheFoldsFindTheirs) {
  StructureSearchOptions options;
  options.rule_base.shape = Shape::gaussian;
  options.learner = test::quick_curve_learner();
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const TrainingData data = shared_temperatures(seed, 8);
    const auto candidates = judge_structures(condense(data, 0.0, flat).value(), options);
    ASSERT_TRUE(candidates) << candidates.error().message;
    const CandidateChoice choice = choose_structure(*candidates);
    const auto rules = static_cast<int>(candidates->at(choice.index).model.rules.size());
    const StructureSearch folds = search_structure(data, test::folds_by_group(data, 8), options).value();
    const auto error_of = [&](int memberships) {
      return folds.curve[static_cast<std::size_t>(memberships - 2)].mean_error;
    };
    EXPECT_LT(error_of(rules), 1.02 * error_of(folds.chosen)) << seed;
  }
}

TEST(GroupDeletion, AGroupThatIsLeftOutHasNoSayInTheChoice) {
  const Model any;
  // The second candidate is far better on the last group alone.
  const std::vector<JudgedCandidate> candidates = {{any, {1.0, 1.1, 0.9, 30.0}}, {any, {2.0, 2.1, 1.9, 1.0}}};
  EXPECT_EQ(choose_structure(candidates, 3).index, 0U);
  EXPECT_NEAR(choose_structure(candidates, 3).mean_error, 1.0, 1e-15);
  const std::vector<JudgedCandidate> steady = {{any, {9.0, 9.1, 8.9, 1.0}}, {any, {2.0, 2.1, 1.9, 30.0}}};
  EXPECT_EQ(choose_structure(steady, 3).index, 1U);
}

}  // namespace
}  // namespace soak::anfis
