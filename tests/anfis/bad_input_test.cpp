// SPDX-License-Identifier: Apache-2.0
// Every entry of the room with data that nobody should have: refused with a message, or a finite valid model. Never a
// NaN in a model.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "anfis/model/rule_base.h"
#include "anfis/select/structure_search.h"
#include "anfis/select/uncertainty.h"
#include "anfis/train/learner.h"
#include "support.h"

namespace soak::anfis {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string fault_of(const base::Error& error) {
  if (error.kind != base::ErrorKind::bad_input) return "refused as another kind: " + error.message;
  return error.message.size() < 15 || error.where.empty() ? "refused without saying why or where" : "";
}

/// Nothing, or what is wrong with a model that was returned.
std::string fault_of(const Model& model, const TrainingData& data) {
  const auto status = validate(model);
  if (!status) return "invalid model: " + status.error().where + ": " + status.error().message;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    if (!std::isfinite(evaluate(model, data.row(i)))) return "no finite value at row " + std::to_string(i);
  }
  return "";
}

std::string fault_of_training(const Model& initial, const TrainingData& data, const Learner& learner) {
  const auto training = train(initial, data, learner);
  if (!training) return fault_of(training.error());
  if (!std::isfinite(training->summary.train_rmse)) return "the training error is not finite";
  return fault_of(training->model, data);
}

std::string fault_of_variance(const Model& model, const TrainingData& data) {
  const auto variance = PredictionVariance::of(model, data);
  if (!variance) return fault_of(variance.error());
  const double at = variance->at(data.row(0), variance->residual_variance());
  return at >= 0.0 && std::isfinite(at) ? "" : "the variance is " + std::to_string(at);
}

std::string fault_of_search(const TrainingData& data) {
  std::vector<int> fold;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    fold.push_back(data.group.empty() ? static_cast<int>(i % 3) : data.group[i] % 3);
  }
  const auto search = search_structure(data, fold, {.max_memberships = 4, .learner = HybridOptions{.epochs = 5}});
  if (!search) return fault_of(search.error());
  for (const auto& point : search->curve) {
    if (!std::isfinite(point.mean_error)) return "a held-out error is not finite";
  }
  return search->chosen >= 2 ? "" : "no structure was chosen";
}

const Learner kLearners[] = {HybridOptions{.epochs = 20}, VariableProjectionOptions{.evaluations = 30},
                             VariableProjectionOptions{.optimiser = Optimiser::sbplx, .evaluations = 30}};

/// What each entry makes of the data, starting from `initial` where that is given.
void expect_defined(const TrainingData& data, const std::string& what, const Model* initial = nullptr) {
  EXPECT_EQ(fault_of_search(data), "") << what << ": search_structure";
  for (const Shape shape : {Shape::bell, Shape::gaussian, Shape::triangle}) {
    for (const int order : {0, 1}) {
      const auto made = grid_rules(data, {.memberships = {2}, .shape = shape, .order = order});
      EXPECT_EQ(made ? fault_of(*made, {}) : fault_of(made.error()), "") << what << ": grid_rules";
      if (!made && initial == nullptr) continue;
      const Model& model = initial != nullptr ? *initial : *made;
      for (const Learner& learner : kLearners) {
        EXPECT_EQ(fault_of_training(model, data, learner), "")
            << what << ": learner " << learner.index() << ' ' << name(shape) << " order " << order;
      }
      EXPECT_EQ(fault_of_variance(model, data), "") << what << ": PredictionVariance";
    }
  }
}

/// 12 good rows.
TrainingData good_rows() {
  TrainingData data;
  for (int i = 0; i < 12; ++i) {
    data.x.push_back(i);
    data.y.push_back(std::sin(0.5 * i));
    data.weight.push_back(1.0 + i % 2);
    data.group.push_back(i % 3);
  }
  data.group_variance = 0.1;
  return data;
}

TEST(BadInput, GoodRowsAreTaken) {
  const TrainingData data = good_rows();
  const Model model = test::grid(data, 2);
  for (const Learner& learner : kLearners) EXPECT_TRUE(train(model, data, learner));
  EXPECT_TRUE(PredictionVariance::of(model, data));
  EXPECT_EQ(fault_of_search(data), "");
}

/// The same error from every entry.
void expect_refused(const TrainingData& data, const std::string& where) {
  const Model model = test::grid(good_rows(), 2);
  for (const Learner& learner : kLearners) {
    const auto training = train(model, data, learner);
    ASSERT_FALSE(training);
    EXPECT_EQ(training.error().where, where);
    EXPECT_EQ(fault_of(training.error()), "");
  }
  ASSERT_FALSE(grid_rules(data, {}));
  EXPECT_EQ(grid_rules(data, {}).error().where, where);
  ASSERT_FALSE(PredictionVariance::of(model, data));
  EXPECT_EQ(PredictionVariance::of(model, data).error().where, where);
  std::vector<int> fold(data.rows());
  for (std::size_t i = 0; i < fold.size(); ++i) fold[i] = static_cast<int>(i % 3);
  ASSERT_FALSE(search_structure(data, fold, {}));
  EXPECT_EQ(search_structure(data, fold, {}).error().where, where);
}

TEST(BadInput, NumbersThatAreNotFiniteAreRefusedByRow) {
  for (const double value : {kNaN, HUGE_VAL, -HUGE_VAL}) {
    for (auto column : {&TrainingData::x, &TrainingData::y, &TrainingData::weight}) {
      TrainingData data = good_rows();
      (data.*column)[4] = value;
      expect_refused(data, "row 4");
    }
  }
  TrainingData data = good_rows();
  data.weight[7] = -1.0;
  expect_refused(data, "row 7");
  data = good_rows();
  data.group_variance = kNaN;
  expect_refused(data, "group_variance");
}

TEST(BadInput, AConstantInputIsRefused) {
  TrainingData data = good_rows();
  data.x.assign(data.x.size(), 3.0);
  expect_refused(data, "x");
  data = {{1.0}, {2.0}};  // one row
  expect_refused(data, "x");
  data = {};
  expect_refused(data, "x");
}

TEST(BadInput, AConstantOutputIsLearned) {
  for (const double level : {0.0, 3.0, -1e-12, 1e12}) {
    TrainingData data = good_rows();
    data.y.assign(data.y.size(), level);
    expect_defined(data, "constant output " + std::to_string(level));
    const auto training = train(test::grid(data, 2), data, VariableProjectionOptions());
    ASSERT_TRUE(training) << level;
    EXPECT_NEAR(evaluate(training->model, 4.5), level, 1e-12 * std::abs(level)) << level;
  }
}

TEST(BadInput, FewerPointsThanParametersAreRefused) {
  const TrainingData data{{0.0, 1.0, 2.0}, {0.0, 1.0, 0.0}};
  for (const Learner& learner : kLearners) {
    const auto training = train(test::grid(data, 2), data, learner);
    ASSERT_FALSE(training);
    EXPECT_EQ(training.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(training.error().where, "x");
  }
  EXPECT_EQ(fault_of_search(data), "");
  EXPECT_EQ(fault_of_variance(test::grid(data, 2), data), "");
}

TEST(BadInput, DuplicatePointsAreLearned) {
  TrainingData data = good_rows();
  for (double& x : data.x) x = std::floor(x / 3.0);  // four points, three times each
  expect_defined(data, "duplicates");
  data.y[1] = 100.0;  // and contradictory
  expect_defined(data, "contradictory duplicates");
}

TEST(BadInput, OneGroupOnlyIsLearned) {
  TrainingData data = good_rows();
  data.group.assign(data.rows(), 7);
  for (const double variance : {0.0, 0.1, 1e20, HUGE_VAL}) {
    data.group_variance = variance;
    expect_defined(data, "one group, variance " + std::to_string(variance));
  }
}

TEST(BadInput, EveryRowItsOwnGroupIsDefined) {
  TrainingData data = good_rows();
  for (std::size_t i = 0; i < data.rows(); ++i) data.group[i] = static_cast<int>(i);
  for (const double variance : {0.1, HUGE_VAL}) {  // free offsets explain everything
    data.group_variance = variance;
    expect_defined(data, "own groups, variance " + std::to_string(variance));
  }
}

TEST(BadInput, MembershipsThatCollapseAreDefined) {
  const TrainingData data = good_rows();
  Model model = test::grid(data, 2);
  for (const double width : {1e-300, 1e-12, 1.0, 1e12, 1e100}) {
    for (Membership& m : model.inputs[0].memberships) m = bell(width, 2.0, 0.0);  // the same one twice
    expect_defined(data, "equal bells of width " + std::to_string(width), &model);
    for (Membership& m : model.inputs[0].memberships) m = gaussian(width, 0.0);
    expect_defined(data, "equal Gaussians of width " + std::to_string(width), &model);
    for (Membership& m : model.inputs[0].memberships) m = gaussian(width, 1e6);  // none near the data
    expect_defined(data, "Gaussians far away of width " + std::to_string(width), &model);
    for (Membership& m : model.inputs[0].memberships) m = {Shape::triangle, {5.0 - width, 5.0, 5.0 + width}};
    if (validate(model)) expect_defined(data, "triangles far away of width " + std::to_string(width), &model);
  }
}

TEST(BadInput, HugeAndSmallNumbersAreDefined) {
  for (const double size : {1e-320, 1e-300, 1e-160, 1e-12, 1e12, 1e90, 1e160, 1e300}) {
    for (auto column : {&TrainingData::x, &TrainingData::y, &TrainingData::weight}) {
      TrainingData data = good_rows();
      for (double& value : data.*column) value *= size;
      const char* which = column == &TrainingData::x ? "x" : column == &TrainingData::y ? "y" : "weight";
      expect_defined(data, std::string(which) + " times 1e" + std::to_string(std::lround(std::log10(size))));
    }
  }
}

TEST(BadInput, NumbersFromTheSmallestToTheLargestAreDefined) {
  constexpr double kMost = std::numeric_limits<double>::max();
  expect_defined({{-kMost, 0.0, 1.0, 2.0, kMost}, {-kMost, 0.0, 1.0, 2.0, kMost}}, "all doubles");
  expect_defined({{0.0, 5e-324, 1e-323, 1.5e-323, 2e-323}, {0.0, 1.0, 0.0, 1.0, 0.0}}, "subnormal inputs");
  expect_defined({{1e9, 1e9 + 1e-6, 1e9 + 2e-6, 1e9 + 3e-6, 1e9 + 4e-6}, {0.0, 1.0, 0.0, 1.0, 0.0}},
                 "steps of rounding");
}

// With free offsets the level of the curve is open until the end of a training: rows without groups would judge it.
TEST(BadInput, CheckingRowsWithoutGroupsCannotJudgeAnOpenLevel) {
  TrainingData train = test::drift_problem(1, 4).data;
  train.group_variance = HUGE_VAL;
  TrainingData check = test::drift_problem(2, 2).data;
  check.group_variance = 0.0;
  check.group.clear();
  const auto hybrid = train_hybrid(test::grid(train), train, {}, &check);
  ASSERT_FALSE(hybrid);
  EXPECT_EQ(hybrid.error().where, "checking data, group_variance");
  EXPECT_FALSE(train_variable_projection(test::grid(train), train, {}, &check));
}

}  // namespace
}  // namespace soak::anfis
