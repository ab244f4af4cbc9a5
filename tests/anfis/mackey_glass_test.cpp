// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "anfis/model/rule_base.h"
#include "anfis/train/learner.h"
#include "published_data.h"

// Hybrid learning against published errors: those of Jang's paper of 1993 and the outputs of MATLAB's anfis.
namespace soak::anfis {
namespace {

Model two_bells(const TrainingData& data, bool scale) {
  return grid_rules(data, {.memberships = {2}, .shape = Shape::bell, .scale = scale}).value();
}

/// Sequential consequents, no bounds, units of the data: what Jang's program does.
Training train_as_jang(const TrainingData& data, int epochs, double initial_step) {
  HybridOptions options = HybridOptions::matlab();
  options.epochs = epochs;
  options.initial_step = initial_step;
  return train_hybrid(two_bells(data, false), data, options).value();
}

Training train_by_default(const TrainingData& data, int epochs, PremiseLimits limits) {
  HybridOptions options;
  options.epochs = epochs;
  options.limits = limits;
  return train_hybrid(two_bells(data, true), data, options).value();
}

struct Errors {
  double train;
  double check;
};

Errors rmse(const test::PublishedData& data, const Model& model, const char* what) {
  const Errors errors = {shape_rmse(data.train, model), shape_rmse(data.check, model)};
  std::printf("%-52s RMSE train %.6f check %.6f\n", what, errors.train, errors.check);
  return errors;
}

Errors percentage(const test::PublishedData& data, const Model& model, const char* what) {
  const Errors errors = {test::average_percentage_error(data.train, model),
                         test::average_percentage_error(data.check, model)};
  std::printf("%-52s APE train %.4f %% check %.4f %%\n", what, errors.train, errors.check);
  return errors;
}

TEST(MackeyGlass, MatlabPresetReproducesMatlabsOutputs) {
  const auto matlab = test::matlab_mackey_glass();
  if (!matlab) GTEST_SKIP() << "skipped: MATLAB's outputs are not here (SOAK_TEST_DATA)";
  const TrainingData& train = matlab->data.train;
  const auto training = train_hybrid(two_bells(train, false), train, HybridOptions::matlab());
  ASSERT_TRUE(training);
  double squares = 0.0;
  for (std::size_t i = 0; i < 1000; ++i) {
    const auto x = i < 500 ? train.row(i) : matlab->data.check.row(i - 500);
    squares += std::pow(evaluate(training->model, x) - matlab->outputs[i], 2);
  }
  const double difference = std::sqrt(squares / 1000.0);
  std::printf("MATLAB's anfis, ten epochs: RMS difference of 1000 outputs %.2g\n", difference);
  // The covariance starts at 1e6 and is rounded to 1e-10: outputs of about 1 that differ by no more than that differ by
  // the order of additions only. Least squares without the prior differs by 1e-3, one epoch more or less by 9e-5.
  EXPECT_LT(difference, 1e-10);
}

TEST(MackeyGlass, SeriesOfTheDemonstrationIsThatOfMatlabsFile) {
  const auto matlab = test::matlab_mackey_glass();
  if (!matlab) GTEST_SKIP() << "skipped: MATLAB's series is not here (SOAK_TEST_DATA)";
  const test::PublishedData ours = test::demonstration_mackey_glass();
  for (std::size_t i = 0; i < 500; ++i) {  // six digits after the point
    EXPECT_NEAR(ours.train.y[i], matlab->data.train.y[i], 5.1e-7) << i;
    EXPECT_NEAR(ours.check.y[i], matlab->data.check.y[i], 5.1e-7) << i;
  }
}

// [Jang93 §V example 3] 16 rules, 500 epochs: RMSE 0.0016 on the training rows and 0.0015 on the checking rows.
TEST(MackeyGlass, JangsConventionsRepeatHisErrors) {
  const test::PublishedData data = test::demonstration_mackey_glass();
  const Errors errors = rmse(data, train_as_jang(data.train, 500, 0.01).model, "Mackey-Glass as Jang, 500 epochs:");
  EXPECT_NEAR(errors.train, 0.0016, 0.5e-4);  // half of the last digit printed
  EXPECT_NEAR(errors.check, 0.0015, 0.5e-4);
}

TEST(MackeyGlass, DefaultsGoBelowJangsErrorsWithinAnyLimits) {
  const test::PublishedData data = test::demonstration_mackey_glass();
  const auto expect_below_jang = [&](PremiseLimits limits, const char* what) {
    const Errors errors = rmse(data, train_by_default(data.train, 500, limits).model, what);
    EXPECT_LT(errors.train, 0.0016) << what;
    EXPECT_LT(errors.check, 0.0015) << what;
  };
  expect_below_jang(PremiseLimits::none, "Mackey-Glass, limits none, 500 epochs:");
  expect_below_jang(PremiseLimits::ordered, "Mackey-Glass, limits ordered, 500 epochs:");
  expect_below_jang(PremiseLimits::resolved, "Mackey-Glass, limits resolved, 500 epochs:");
}

// Three of the twenty starts that ./run bench makes: those reach 0.0012 and 0.0011.
TEST(MackeyGlass, VariableProjectionFromAFewStartsGoesBelowJangsErrors) {
  const test::PublishedData data = test::demonstration_mackey_glass();
  const VariableProjectionOptions options{.evaluations = 300, .limits = PremiseLimits::ordered, .starts = 3};
  const auto training = train_variable_projection(two_bells(data.train, true), data.train, options);
  ASSERT_TRUE(training);
  const Errors errors = rmse(data, training->model, "Mackey-Glass, variable projection, 3 starts:");
  EXPECT_LT(errors.train, 0.9 * 0.0016);
  EXPECT_LT(errors.check, 0.9 * 0.0015);
}

// The other series is the same equation on another path, of which the first half covers the second less densely: 95 %
// of the checking rows have a training row within 0.057, against 0.033 above. Thirty of the 500 checking rows make
// three quarters of the square error; the others' RMSE is 0.0013.
TEST(MackeyGlass, DefaultsLearnTheSeriesOfTheVectorFile) {
  const test::PublishedData data = test::mackey_glass();
  const Errors errors = rmse(data, train_by_default(data.train, 500, PremiseLimits::resolved).model,
                             "the other series, limits resolved, 500 epochs:");
  EXPECT_LT(errors.train, 0.0012);
  EXPECT_LT(errors.check, 0.0028);
}

// [Jang93 §V example 2] 8 rules, 199.5 epochs (200 solutions for the consequents, 199 steps): average percentage error
// 0.043 % on the training points and 1.066 % on the checking points. The initial step is 0.1.
TEST(ThreeInputFunction, JangsConventionsRepeatHisErrors) {
  const test::PublishedData data = test::three_input_function();
  const Errors errors =
      percentage(data, train_as_jang(data.train, 200, 0.1).model, "three inputs as Jang, 199.5 epochs:");
  EXPECT_NEAR(errors.train, 0.043, 0.5e-3);  // half of the last digit printed
  EXPECT_NEAR(errors.check, 1.066, 0.5e-3);
}

// The function is singular at y = 0 and z = 0, outside the points in 1..6, and without limits bells go there (centres
// at -1.7 and -1.4). Inside the limits 200 epochs of hybrid learning end at seven times Jang's error on the training
// points. That is the epochs' doing, not the limits': see the next test.
TEST(ThreeInputFunction, DefaultsGoBelowJangsErrorsWhereCentresMayLeaveTheData) {
  const test::PublishedData data = test::three_input_function();
  const auto trained = [&](PremiseLimits limits, const char* what) {
    return percentage(data, train_by_default(data.train, 200, limits).model, what);
  };
  const Errors none = trained(PremiseLimits::none, "three inputs, limits none, 200 epochs:");
  EXPECT_LT(none.train, 0.043);
  EXPECT_LT(none.check, 1.066);
  const Errors ordered = trained(PremiseLimits::ordered, "three inputs, limits ordered, 200 epochs:");
  const Errors resolved = trained(PremiseLimits::resolved, "three inputs, limits resolved, 200 epochs:");
  for (const Errors& errors : {ordered, resolved}) {
    EXPECT_LT(errors.train, 1.05 * 0.3129);
    EXPECT_LT(errors.check, 1.05 * 2.0458);
  }
}

// Which of the minima within the limits a start comes to is chance (one start: 0.32 and 1.54), and the training points
// choose among them: the best of them is not the best between the points. So it is with SciPy's search within the same
// limits (tests/blind/test_jang_three_inputs.py): below 0.043 at the points, never below 1.10 between them.
TEST(ThreeInputFunction, VariableProjectionFromTwentyStartsReachesJangsTrainingErrorWithinTheLimits) {
  const test::PublishedData data = test::three_input_function();
  const VariableProjectionOptions options{.limits = PremiseLimits::resolved, .starts = 20};
  const auto training = train_variable_projection(two_bells(data.train, true), data.train, options);
  ASSERT_TRUE(training);
  const Errors errors = percentage(data, training->model, "three inputs, limits resolved, 20 starts:");
  EXPECT_LT(errors.train, 1.05 * 0.0295);
  EXPECT_LT(errors.check, 1.05 * 1.297);
}

// Beyond the published figures; the 125 checking points choose nothing here.
TEST(ThreeInputFunction, VariableProjectionGoesBelowJangsErrorsFromOneStart) {
  const test::PublishedData data = test::three_input_function();
  const VariableProjectionOptions options{.evaluations = 500, .limits = PremiseLimits::ordered};
  const auto training = train_variable_projection(two_bells(data.train, true), data.train, options);
  ASSERT_TRUE(training);
  const Errors errors = percentage(data, training->model, "three inputs, variable projection, 1 start:");
  EXPECT_LT(errors.train, 0.043);
  EXPECT_LT(errors.check, 0.5 * 1.066);
}

}  // namespace
}  // namespace soak::anfis
