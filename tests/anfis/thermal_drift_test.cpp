// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "anfis/train/learner.h"
#include "curves.h"
#include "published_data.h"
#include "support.h"
#include "tests/long_tests.h"

namespace soak::anfis {
namespace {

struct Outcome {
  std::vector<double> anfis;   // worst error between temperatures, sorted
  std::vector<double> spline;  // the same of the spline through plateau means
};

Outcome run_campaigns(unsigned seeds, int runs, Shape shape) {
  Outcome outcome;
  std::map<int, int> rules;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const test::DriftProblem problem = test::drift_problem(seed, runs);
    const int chosen = test::search_curve(problem.data, std::min(runs, 5), shape).chosen;
    const Model model = test::learn_curve(problem.data, chosen, shape);
    ++rules[chosen];
    outcome.anfis.push_back(worst_shape_error(problem, [&](double t) { return evaluate(model, t); }));
    outcome.spline.push_back(worst_shape_error(problem, test::plateau_spline(problem.data, -30.0, 5.0, 21)));
  }
  std::sort(outcome.anfis.begin(), outcome.anfis.end());
  std::sort(outcome.spline.begin(), outcome.spline.end());
  const auto at = [&](const std::vector<double>& errors, std::size_t tenth) { return errors[seeds * tenth / 10]; };
  std::printf("%2d runs, %-8s: median %.4f p90 %.4f worst %.4f; spline %.4f %.4f %.4f; rules", runs,
              std::string(name(shape)).c_str(), at(outcome.anfis, 5), at(outcome.anfis, 9), outcome.anfis.back(),
              at(outcome.spline, 5), at(outcome.spline, 9), outcome.spline.back());
  for (const auto& [count, times] : rules) std::printf(" %d (%d)", count, times);
  std::printf("\n");
  return outcome;
}

// 21 temperatures, a curve that spans 0.5 with one or two Gaussian features; the noise alone (0.002 / sqrt(runs) a
// plateau) leaves 0.0014 and 0.0018 at three standard errors of 20 and 13 runs. [AH05 §6.4.3] reports 0.005 at the
// plateaus, against the means that it was fitted to; here the error is that against the truth between them too.
TEST(ThermalDrift, OfTwentyRunsIsLearnedToATwoHundredthBetweenTemperaturesOnFiftySeeds) {
  SOAK_LONG_TEST();
  for (const Shape shape : {Shape::gaussian, Shape::bell}) {
    EXPECT_LE(run_campaigns(50, 20, shape).anfis.back(), 0.0025);
  }
}

TEST(ThermalDrift, OfThirteenRunsIsLearnedAsWellAndNoWorseThanBySplines) {
  const Outcome outcome = run_campaigns(50, 13, Shape::gaussian);
  EXPECT_LE(outcome.anfis.back(), 0.0025);
  EXPECT_LE(outcome.anfis[25], 1.05 * outcome.spline[25]);
}

TEST(ThermalDrift, OfFourRunsIsLearnedToAHundredth) {
  for (const Shape shape : {Shape::gaussian, Shape::bell}) {
    EXPECT_LE(run_campaigns(20, 4, shape).anfis.back(), 0.005);
  }
}

double held_out_error(const Model& model) {
  TrainingData held_out = test::gyro_drift(false);
  held_out.group_variance = 1.0;
  return shape_rmse(held_out, model);
}

// 13 runs to learn from, 7 that nothing has seen. The noise of the 7 runs alone is 0.1942 deg/h in shape (the truth
// itself comes to 0.1938 on them); a curve of 14 free numbers from 13 runs of noise 0.205 adds 0.205 sqrt(14 / 273) =
// 0.046 in quadrature: 1.028 of the floor, in the mean over such data. Measured 1.0397 (9 bells), and 1.0314 of the
// spline's distance to the truth; the natural spline through the means 1.044. The bounds leave 0.2 and 1 %.
constexpr double kDriftFloor_degph = 0.1942;

TEST(GyroDrift, OnUnseenRunsComesNearerToTheNoiseFloorThanASplineThroughTheMeans) {
  TrainingData train = test::gyro_drift(true);
  train.group_variance = 1.0;  // of the size of the noise variance, as the weights are 1: relative to it
  const int chosen = test::search_curve(train, 13, Shape::bell).chosen;
  const Model model = test::learn_curve(train, chosen, Shape::bell);
  const double error = held_out_error(model);
  const test::ShapeError to_truth = test::shape_error(test::gyro_truth(), [&](double t) { return evaluate(model, t); });
  std::printf("unseen runs: %d rules, shape RMSE %.4f deg/h = %.4f of the floor; against the truth %.4f\n", chosen,
              error, error / kDriftFloor_degph, to_truth.rmse);
  EXPECT_LE(error, 1.042 * kDriftFloor_degph);
  EXPECT_LE(to_truth.rmse, 1.042 * 0.0609);  // the spline's
}

// 1.03 of the floor and no farther from the truth than the spline: of 140 systems none does both, even where the best
// is chosen on the unseen runs and on the truth themselves. One of them comes to 1.024 on the seven runs, by luck: it
// is 2.6 times as far from the truth as the spline. Indicative, as other systems could be thought of.
TEST(GyroDrift, NoChoiceMadeByHindsightIsBothNearTheFloorAndNearTheTruth) {
  SOAK_LONG_TEST();
  TrainingData train = test::gyro_drift(true);
  train.group_variance = 1.0;
  double best = HUGE_VAL;
  double best_near_truth = HUGE_VAL;
  const auto try_one = [&](int rules, Shape shape, const VariableProjectionOptions& options) {
    const auto training = train_variable_projection(test::grid(train, rules, shape), train, options);
    ASSERT_TRUE(training);
    const Model& model = training->model;
    const double error = held_out_error(model);
    best = std::min(best, error);
    const auto curve = [&](double t) { return evaluate(model, t); };
    if (test::shape_error(test::gyro_truth(), curve).rmse <= 0.0609) best_near_truth = std::min(best_near_truth, error);
  };
  for (int rules = 4; rules <= 10; ++rules) {
    for (const Shape shape : {Shape::bell, Shape::gaussian}) {
      for (const double smoothness : {0.0, 1e-8, 3e-8, 1e-7, 3e-7}) {
        for (const int starts : {1, 4}) try_one(rules, shape, {.smoothness = smoothness, .starts = starts});
      }
    }
  }
  std::printf("by hindsight: %.4f of the floor, no farther from the truth than the spline %.4f\n",
              best / kDriftFloor_degph, best_near_truth / kDriftFloor_degph);
  EXPECT_LT(best_near_truth, HUGE_VAL);
  EXPECT_GT(best_near_truth, 1.03 * kDriftFloor_degph);
}

// The thesis' own use of 13 and 7 runs [AH05 §6.4.1]: the 7 stop the training and choose the rules, so this figure is
// not an unseen one.
TEST(GyroDrift, WithCheckingRunsInTheLoopReachesTheNoiseFloorOfThem) {
  TrainingData train = test::gyro_drift(true);
  TrainingData check = test::gyro_drift(false);
  train.group_variance = check.group_variance = 1.0;
  double hybrid = HUGE_VAL;
  double projection = HUGE_VAL;
  for (int rules = 4; rules <= 10; ++rules) {
    const Model initial = test::grid(train, rules);
    hybrid = std::min(hybrid, train_hybrid(initial, train, {}, &check)->summary.check_rmse);
    projection = std::min(projection,
                          train_variable_projection(initial, train, test::curve_learner(), &check)->summary.check_rmse);
  }
  std::printf("checking runs in the loop: hybrid %.3f, variable projection %.3f of the floor\n",
              hybrid / kDriftFloor_degph, projection / kDriftFloor_degph);
  EXPECT_LE(hybrid, 1.05 * kDriftFloor_degph);
  EXPECT_LE(projection, 1.05 * kDriftFloor_degph);
}

}  // namespace
}  // namespace soak::anfis
