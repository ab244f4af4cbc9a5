// SPDX-License-Identifier: Apache-2.0
// What learning reaches on published problems, beside what was published. Accuracy only; tests/anfis asserts it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "anfis/linear/least_squares.h"
#include "anfis/model/rule_base.h"
#include "anfis/select/fuzzy_ols.h"
#include "anfis/select/structure_search.h"
#include "anfis/train/learner.h"
#include "tests/anfis/curves.h"
#include "tests/anfis/published_data.h"
#include "tests/anfis/support.h"
#include "tests/anfis/ten_inputs.h"

namespace soak::anfis {
namespace {

/// Two bells per input.
Model two_bells(const TrainingData& data, bool scale = true) {
  RuleBaseOptions options;
  options.memberships = {2};
  options.scale = scale;
  return grid_rules(data, options).value();
}

HybridOptions hybrid(int epochs, PremiseLimits limits) {
  HybridOptions options;
  options.epochs = epochs;
  options.limits = limits;
  return options;
}

VariableProjectionOptions projection(int starts, PremiseLimits limits) {
  VariableProjectionOptions options;
  options.starts = starts;
  options.limits = limits;
  options.evaluations = 1000;
  options.min_rmse_change = 1e-8;
  return options;
}

void row(const char* what, double train, double check) { std::printf("  %-64s %9.6f %9.6f\n", what, train, check); }

void mackey_glass(const char* title, const test::PublishedData& data) {
  std::printf("%s: RMSE train, check\n", title);
  const auto print = [&](const char* what, const Model& initial, const Learner& learner) {
    const Training training = train(initial, data.train, learner).value();
    row(what, shape_rmse(data.train, training.model), shape_rmse(data.check, training.model));
  };
  HybridOptions as_jang = HybridOptions::matlab();
  as_jang.epochs = 500;
  print("hybrid, 500 epochs, MATLAB's conventions", two_bells(data.train, false), as_jang);
  const Model initial = two_bells(data.train);
  print("hybrid, 500 epochs", initial, hybrid(500, PremiseLimits::resolved));
  print("hybrid, 500 epochs, no limits", initial, hybrid(500, PremiseLimits::none));
  print("variable projection, 1 start", initial, projection(1, PremiseLimits::ordered));
  print("variable projection, 20 starts", initial, projection(20, PremiseLimits::ordered));
}

void matlab() {
  const auto data = test::matlab_mackey_glass();
  std::printf("MATLAB R2012b's anfis on Mackey-Glass, 10 epochs\n");
  if (!data) {
    std::printf("  skipped: its outputs are not here (SOAK_TEST_DATA)\n");
    return;
  }
  const TrainingData& rows = data->data.train;
  const Training ours = train_hybrid(two_bells(rows, false), rows, HybridOptions::matlab()).value();
  double squares = 0.0;
  for (std::size_t i = 0; i < data->outputs.size(); ++i) {
    const auto x = i < rows.rows() ? rows.row(i) : data->data.check.row(i - rows.rows());
    squares += std::pow(evaluate(ours.model, x) - data->outputs[i], 2);
  }
  row("RMSE train, check (MATLAB: 0.002550, 0.002502)", ours.summary.train_rmse,
      shape_rmse(data->data.check, ours.model));
  std::printf("  RMS difference of the outputs to MATLAB's: %.2g\n",
              std::sqrt(squares / static_cast<double>(data->outputs.size())));
}

void three_inputs() {
  const test::PublishedData data = test::three_input_function();
  std::printf("Three-input function: APE train, check in %% [Jang93: 0.043, 1.066]\n");
  const auto print = [&](const char* what, const Model& initial, const Learner& learner, bool keep_best_check) {
    const Training training = train(initial, data.train, learner, keep_best_check ? &data.check : nullptr).value();
    row(what, test::average_percentage_error(data.train, training.model),
        test::average_percentage_error(data.check, training.model));
  };
  HybridOptions as_jang = HybridOptions::matlab();
  as_jang.epochs = 200;
  as_jang.initial_step = 0.1;
  print("hybrid, 199.5 epochs, Jang's conventions", two_bells(data.train, false), as_jang, false);
  const Model initial = two_bells(data.train);
  print("hybrid, 200 epochs, no limits", initial, hybrid(200, PremiseLimits::none), false);
  print("the same, best on the checking data", initial, hybrid(200, PremiseLimits::none), true);
  print("variable projection, 1 start", initial, projection(1, PremiseLimits::ordered), false);
  print("variable projection, 20 starts, best on the checking data", initial, projection(20, PremiseLimits::ordered),
        true);
}

struct Curve {
  std::string name;
  std::function<double(double)> at;
};

Curve learned(const TrainingData& data, int memberships, Shape shape) {
  const Model model = test::learn_curve(data, memberships, shape);
  return {std::to_string(memberships) + ' ' + std::string(name(shape)) + " rules",
          [model](double t) { return evaluate(model, t); }};
}

/// Curves with the number of rules of the least cross-validated error and with that of the one-standard-error rule.
std::vector<Curve> searched(const TrainingData& data, int folds, Shape shape) {
  const StructureSearch found = test::search_curve(data, folds, shape);
  return {learned(data, found.best, shape), learned(data, found.chosen, shape)};
}

/// The spline at the level of the mean run.
Curve spline_through_means(const TrainingData& data, double first, double spacing) {
  const auto spline = test::plateau_spline(data, first, spacing, 21);
  double level = 0.0;
  for (std::size_t i = 0; i < data.rows(); ++i)
    level += (data.y[i] - spline(data.x[i])) / static_cast<double>(data.rows());
  return {"natural cubic spline through the means", [=](double t) { return spline(t) + level; }};
}

double held_out_rmse(TrainingData data, const Curve& curve, double group_variance) {
  data.group_variance = group_variance;
  std::vector<double> r;
  for (std::size_t i = 0; i < data.rows(); ++i) r.push_back(data.y[i] - curve.at(data.x[i]));
  return shape_rmse(data, std::move(r));
}

void gyro_drift() {
  TrainingData data = test::gyro_drift(true);
  data.group_variance = 1.0;
  const TrainingData held_out = test::gyro_drift(false);
  const auto truth = test::gyro_truth();
  std::printf(
      "gyro_drift_21x20, 13 runs to learn, 7 unseen, deg/h: shape RMSE (floor 0.194), absolute RMSE (0.269),\n"
      "error of the shape against the dense truth: RMSE, worst\n");
  std::vector<Curve> curves = {spline_through_means(data, -40.0, 6.0)};
  for (const Shape shape : {Shape::bell, Shape::gaussian, Shape::two_sided_gaussian}) {
    for (Curve& curve : searched(data, 13, shape)) curves.push_back(std::move(curve));
  }
  for (const Curve& curve : curves) {
    const test::ShapeError error = test::shape_error(truth, curve.at);
    std::printf("  %-48s %.4f (%.3f x floor) %.4f   %.4f %.4f\n", curve.name.c_str(),
                held_out_rmse(held_out, curve, 1.0), held_out_rmse(held_out, curve, 1.0) / 0.1942,
                held_out_rmse(held_out, curve, 0.0), error.rmse, error.worst);
  }
}

void print_sorted(const char* what, std::vector<double> errors) {
  std::sort(errors.begin(), errors.end());
  std::printf("  %-48s median %.5f, 9 of 10 below %.5f, worst %.5f\n", what, errors[errors.size() / 2],
              errors[errors.size() * 9 / 10], errors.back());
}

/// One-standard-error rule and final fit with one learner.
double worst_error_with(const test::DriftProblem& problem, Shape shape, const Learner& quick, const Learner& thorough) {
  StructureSearchOptions search;
  search.rule_base.shape = shape;
  search.learner = quick;
  const auto found = search_structure(problem.data, test::folds_by_group(problem.data, 5), search).value();
  const Model model = train(test::grid(problem.data, found.chosen, shape), problem.data, thorough).value().model;
  return test::worst_shape_error(problem, [&](double t) { return evaluate(model, t); });
}

/// What the product does: bells and Gaussians compete, the lesser cross-validated error wins.
double worst_error_of_both(const test::DriftProblem& problem) {
  const StructureSearch bells = test::search_curve(problem.data, 5, Shape::bell);
  const StructureSearch gaussians = test::search_curve(problem.data, 5, Shape::gaussian);
  const auto error = [](const StructureSearch& s) {
    return s.curve[static_cast<std::size_t>(s.chosen - 2)].mean_error;
  };
  const bool bell_wins = error(bells) < error(gaussians);
  const Model model = test::learn_curve(problem.data, bell_wins ? bells.chosen : gaussians.chosen,
                                        bell_wins ? Shape::bell : Shape::gaussian);
  return test::worst_shape_error(problem, [&](double t) { return evaluate(model, t); });
}

void thermal_drift(int runs) {
  std::printf(
      "One-input drift, 21 temperatures x %d runs, 50 seeds, deg/s: worst shape error between -30 and 70 deg C\n",
      runs);
  std::vector<double> spline;
  std::map<std::string, std::vector<double>> errors;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const test::DriftProblem problem = test::drift_problem(seed, runs);
    for (const Shape shape : {Shape::gaussian, Shape::bell}) {
      const std::vector<Curve> curves = searched(problem.data, 5, shape);
      const std::string kind(name(shape));
      errors[kind + ", least error"].push_back(test::worst_shape_error(problem, curves[0].at));
      errors[kind + ", one standard error"].push_back(test::worst_shape_error(problem, curves[1].at));
    }
    errors["bells and gaussians compete"].push_back(worst_error_of_both(problem));
    VariableProjectionOptions unpriced_quick = test::quick_curve_learner();
    VariableProjectionOptions unpriced = test::curve_learner();
    unpriced_quick.smoothness = unpriced.smoothness = 0.0;
    errors["gaussian, no price of curvature"].push_back(
        worst_error_with(problem, Shape::gaussian, unpriced_quick, unpriced));
    errors["gaussian, hybrid learning"].push_back(
        worst_error_with(problem, Shape::gaussian, HybridOptions(), HybridOptions()));
    spline.push_back(test::worst_shape_error(problem, test::plateau_spline(problem.data, -30.0, 5.0, 21)));
  }
  for (const auto& [what, worst] : errors) print_sorted(what.c_str(), worst);
  print_sorted("natural cubic spline through the means", spline);
}

void ten_inputs(const char* what, const test::TenInputs& problem) {
  FuzzyOlsOptions options;
  options.clusters = {6, 12};
  const FuzzyOls compact = fuzzy_ols(problem.train, options).value();
  const Training trained = train_hybrid(compact.model, problem.train, hybrid(100, PremiseLimits::resolved)).value();
  std::printf(
      "  %-14s %2zu rules, %3zu consequents: RMSE on fresh rows / noise %.3f from fuzzy_ols, %.3f after 100 epochs\n",
      what, trained.model.rules.size(), consequent_count(trained.model),
      shape_rmse(problem.test, compact.model) / problem.noise, shape_rmse(problem.test, trained.model) / problem.noise);
}

void nist(const char* name) {
  const test::CertifiedFit set = test::nist_linear(name);
  const LeastSquaresFit fit = solve_least_squares(set.a, set.y);
  const double sigma = std::sqrt(fit.residual_sum_of_squares / static_cast<double>(set.a.rows() - set.a.cols()));
  double value_digits = 99.0;
  double sd_digits = 99.0;
  for (Eigen::Index k = 0; k < set.a.cols(); ++k) {
    value_digits = std::min(value_digits, test::digits(fit.coefficients(k), set.b(k)));
    sd_digits = std::min(sd_digits, test::digits(sigma * fit.covariance_factor.row(k).norm(), set.sd(k)));
  }
  std::printf("  %-14s %.1f digits of the coefficients, %.1f of their standard deviations\n", name, value_digits,
              sd_digits);
}

}  // namespace
}  // namespace soak::anfis

int main() {
  using namespace soak::anfis;
  mackey_glass("Mackey-Glass, MATLAB's demonstration series [Jang93: 0.0016, 0.0015]",
               test::demonstration_mackey_glass());
  mackey_glass("Mackey-Glass, the series of tests/data/vectors", test::mackey_glass());
  matlab();
  three_inputs();
  gyro_drift();
  thermal_drift(20);
  thermal_drift(13);
  std::printf("Ten inputs of five sets: a grid would have 9,765,625 rules\n");
  ten_inputs("Friedman", test::friedman());
  ten_inputs("saturations", test::saturations());
  std::printf("NIST StRD, least digits that agree with the certified values\n");
  nist("filip");
  nist("wampler4");
  return 0;
}
