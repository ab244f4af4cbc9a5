// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "anfis/model/one_input.h"
#include "support.h"

namespace soak::anfis {
namespace {

// The unscaled parameters of the vector file in a model whose scales are 1 and 0.
Model vector_model(const nlohmann::json& v, int order) {
  std::vector<CurveRule> rules;
  for (std::size_t i = 0; i < v["a"].size(); ++i) {
    rules.push_back({v["a"][i], v["b"][i], v["c"][i], order == 1 ? v["consequents_slope"][i].get<double>() : 0.0,
                     v["consequents_offset"][i]});
  }
  Model model = curve_model(Shape::bell, rules);
  model.order = order;
  model.inputs[0].min = -60.0;
  model.inputs[0].max = 90.0;
  return model;
}

// The same function with the input scaled about 15 by 75 and the output about -0.05 by 0.4.
Model rescaled(const Model& model) {
  const double centre = 15.0, half_range = 75.0, out_centre = -0.05, out_half_range = 0.4;
  std::vector<CurveRule> rules = curve_rules(model);
  for (CurveRule& rule : rules) {
    rule.offset = (rule.offset + rule.gain * centre - out_centre) / out_half_range;
    rule.gain = rule.gain * half_range / out_half_range;
    rule.width /= half_range;
    rule.centre = (rule.centre - centre) / half_range;
  }
  Model other = curve_model(curve_shape(model), rules);
  other.order = model.order;
  other.inputs[0].scale = {centre, half_range};
  other.output = {out_centre, out_half_range};
  return other;
}

TEST(Model, ReproducesAnotherImplementationForBothOrdersInAnyScaling) {
  const auto v = nlohmann::json::parse(test::read_vector_file("fis_bell_1in.json"));
  const auto x = v["x"].get<std::vector<double>>();
  for (const int order : {0, 1}) {
    const auto expected = v[order == 1 ? "y" : "y_order0"].get<std::vector<double>>();
    for (const Model& model : {vector_model(v, order), rescaled(vector_model(v, order))}) {
      ASSERT_TRUE(validate(model));
      std::vector<double> y(x.size());
      evaluate(model, x, y);
      for (std::size_t i = 0; i < x.size(); ++i) {
        EXPECT_NEAR(y[i], expected[i], 1e-14) << "order " << order << " x " << x[i];
        EXPECT_EQ(y[i], evaluate(model, x[i]));
      }
    }
  }
}

Model two_rules(Shape shape, double slope) {
  Model model = curve_model(shape, std::vector<CurveRule>{{0.1, slope, -1.0, 2.0, 0.5}, {0.1, slope, 1.0, -3.0, 0.25}});
  model.inputs[0].min = -1.0;
  model.inputs[0].max = 1.0;
  return model;
}

std::vector<double> strengths_at(const Model& model, std::vector<double> x) {
  std::vector<double> strengths(model.rules.size());
  firing_strengths(model, x, strengths);
  return strengths;
}

TEST(Model, GaussianStrengthsAreThoseOfTheFormula) {
  Model model = two_rules(Shape::gaussian, 0.0);
  model.inputs[0].memberships = {gaussian(0.8, -1.0), gaussian(0.5, 1.0)};
  const std::vector<double> strengths = strengths_at(model, {0.2});
  const double first = std::exp(-0.5 * 1.2 * 1.2 / (0.8 * 0.8));
  const double second = std::exp(-0.5 * 0.8 * 0.8 / (0.5 * 0.5));
  EXPECT_NEAR(strengths[0], first / (first + second), 1e-15);
  EXPECT_NEAR(strengths[1], second / (first + second), 1e-15);
}

TEST(Model, OnlyTheNearestRuleRemainsWhereNoneFires) {
  const Model model = two_rules(Shape::gaussian, 0.0);  // exp(-0.5 (9/0.1)^2) underflows at x = 10
  EXPECT_DOUBLE_EQ(evaluate(model, 10.0), -3.0 * 10.0 + 0.25);
  EXPECT_DOUBLE_EQ(evaluate(model, -10.0), 2.0 * -10.0 + 0.5);
  EXPECT_FALSE(infer(model, std::vector{10.0}).fired);
  EXPECT_TRUE(infer(model, std::vector{0.9}).fired);
}

TEST(Model, OnlyTheNearestRuleRemainsBetweenTriangles) {
  Model model = two_rules(Shape::gaussian, 0.0);
  model.inputs[0].memberships = {{Shape::triangle, {-2.0, -1.0, -0.5}}, {Shape::triangle, {0.5, 1.0, 2.0}}};
  EXPECT_DOUBLE_EQ(evaluate(model, -0.2), 2.0 * -0.2 + 0.5);
  EXPECT_DOUBLE_EQ(evaluate(model, 0.2), -3.0 * 0.2 + 0.25);
  EXPECT_DOUBLE_EQ(evaluate(model, 0.0), 0.5 * (0.5 + 0.25));  // as far from one as from the other
  EXPECT_FALSE(infer(model, std::vector{0.0}).fired);
}

TEST(Model, BellStrengthsKeepTheirRatioFarOut) {
  const Model model = two_rules(Shape::bell, 60.0);
  // (1e5)^-120 underflows; the ratio tends to ((x-1)/(x+1))^120
  const std::vector<double> strengths = strengths_at(model, {1e4});
  const double ratio = std::pow((1e4 - 1.0) / (1e4 + 1.0), 120.0);
  EXPECT_NEAR(strengths[0], ratio / (1.0 + ratio), 1e-12);
  EXPECT_NEAR(strengths[0] + strengths[1], 1.0, 1e-15);
}

// Two inputs, three rules: the second asks only about the first input, the third only about the second.
Model two_inputs(TNorm t_norm) {
  Model model;
  model.t_norm = t_norm;
  model.inputs.resize(2);
  model.inputs[0].memberships = {bell(0.6, 1.5, -0.5), gaussian(0.4, 0.5)};
  model.inputs[1].memberships = {gaussian(0.7, 0.1), {Shape::triangle, {-1.0, 0.2, 1.4}}};
  model.rules = {{{0, 0}, {1.0, -0.5}, 0.2, {}}, {{1, kAny}, {0.0, 2.0}, -1.0, {0}}, {{kAny, 1}, {0.3, 0.4}, 0.5, {}}};
  return model;
}

TEST(Model, OfTwoInputsIsThatOfTheFormulaForBothTNorms) {
  const double u = 0.3, v = -0.4;
  const double a = 1.0 / (1.0 + std::pow(0.8 / 0.6, 3.0)), b = std::exp(-0.5 * std::pow(0.2 / 0.4, 2));
  const double c = std::exp(-0.5 * std::pow(0.5 / 0.7, 2)), d = 0.6 / 1.2;
  for (const TNorm t_norm : {TNorm::product, TNorm::minimum}) {
    const double w = t_norm == TNorm::product ? a * c : std::min(a, c);
    const double f = w * (u - 0.5 * v + 0.2) + b * (2.0 * v - 1.0) + d * (0.3 * u + 0.4 * v + 0.5);
    ASSERT_TRUE(validate(two_inputs(t_norm)));
    // A dozen operations of rounding error 1e-16 on numbers near 1.
    EXPECT_NEAR(evaluate(two_inputs(t_norm), std::vector{u, v}), f / (w + b + d), 2e-15) << name(t_norm);
  }
}

TEST(Model, CountsItsParameters) {
  EXPECT_EQ(premise_count(two_inputs(TNorm::product)), 3U + 2U + 2U + 3U);
  EXPECT_EQ(consequent_count(two_inputs(TNorm::product)), 3U + 2U + 3U);
  Model constant = two_inputs(TNorm::product);
  constant.order = 0;
  EXPECT_EQ(consequent_count(constant), 3U);
}

TEST(Model, SaysWhetherAPointLiesInTheRangeOfTheTrainingData) {
  Model model = two_inputs(TNorm::product);
  for (Input& input : model.inputs) {
    input.min = -1.0;
    input.max = 2.0;
  }
  EXPECT_TRUE(infer(model, std::vector{-1.0, 2.0}).in_range);
  EXPECT_FALSE(infer(model, std::vector{0.0, 2.1}).in_range);
  EXPECT_FALSE(infer(model, std::vector{-1.1, 0.0}).in_range);
  EXPECT_FALSE(infer(model, std::vector{std::nan(""), 0.0}).in_range);
}

TEST(Model, IsFiniteForEveryFiniteInput) {
  for (const Model& model : {two_rules(Shape::gaussian, 0.0), two_rules(Shape::bell, 2.0), two_rules(Shape::bell, 1e3),
                             rescaled(two_rules(Shape::bell, 2.0))}) {
    for (const double size : {0.0, 1e-320, 1e-8, 1.0, 30.0, 1e8, 1e154, 1e300, std::numeric_limits<double>::max()}) {
      for (const double x : {size, -size, 1.0 + size, -1.0 - size}) {
        EXPECT_TRUE(std::isfinite(evaluate(model, x))) << x;
      }
    }
  }
}

std::string where_of(Model model, void (*change)(Model&)) {
  change(model);
  const auto status = validate(model);
  return status ? std::string("accepted") : status.error().where;
}

TEST(Model, RefusesWhatItCannotEvaluateAndNamesTheField) {
  const auto where = [](auto change) { return where_of(two_rules(Shape::bell, 2.0), change); };
  EXPECT_EQ(where([](Model&) {}), "accepted");
  EXPECT_EQ(where([](Model& m) { m.inputs[0].memberships[1].parameters[2] = std::nan(""); }),
            "inputs[0].memberships[1].centre");
  EXPECT_EQ(where([](Model& m) { m.inputs[0].memberships[0].parameters[0] = 0.0; }), "inputs[0].memberships[0].width");
  EXPECT_EQ(where([](Model& m) { m = two_rules(Shape::gaussian, 2.0); }), "inputs[0].memberships[0].unused parameter");
  EXPECT_EQ(where([](Model& m) { m.order = 0; }), "rules[0].gains[0]");
  EXPECT_EQ(where([](Model& m) { m.order = 2; }), "order");
  EXPECT_EQ(where([](Model& m) { m.rules.clear(); }), "rules");
  EXPECT_EQ(where([](Model& m) { m.inputs.clear(); }), "inputs");
  EXPECT_EQ(where([](Model& m) { m.inputs[0].scale.half_range = 0.0; }), "inputs[0].scale.half_range");
  EXPECT_EQ(where([](Model& m) { m.output.centre = HUGE_VAL; }), "output.centre");
  EXPECT_EQ(where([](Model& m) { m.inputs[0].min = 2.0; }), "inputs[0].min, max");
}

TEST(Model, RefusesRulesThatDoNotFitTheInputs) {
  const auto where = [](auto change) { return where_of(two_inputs(TNorm::product), change); };
  EXPECT_EQ(where([](Model&) {}), "accepted");
  EXPECT_EQ(where([](Model& m) { m.rules[1].premise = {1}; }), "rules[1]");
  EXPECT_EQ(where([](Model& m) { m.rules[2].gains.push_back(0.0); }), "rules[2]");
  EXPECT_EQ(where([](Model& m) { m.rules[0].premise[1] = 2; }), "rules[0].premise[1]");
  EXPECT_EQ(where([](Model& m) { m.rules[0].premise[1] = -2; }), "rules[0].premise[1]");
  EXPECT_EQ(where([](Model& m) { m.rules[1].premise[0] = kAny; }), "rules[1].premise");
  EXPECT_EQ(where([](Model& m) { m.rules[1].gains[0] = 0.1; }), "rules[1].gains[0]");
  EXPECT_EQ(where([](Model& m) { m.rules[1].dropped = {2}; }), "rules[1].dropped");
  EXPECT_EQ(where([](Model& m) { m.rules[1].offset = -2e100; }), "rules[1].offset");
  EXPECT_EQ(where([](Model& m) { m.rules = {{{kAny, kAny}, {1.0, 2.0}, 0.0, {}}}; }), "accepted");  // the only rule
}

}  // namespace
}  // namespace soak::anfis
