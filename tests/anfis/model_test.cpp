// SPDX-License-Identifier: Apache-2.0
#include "anfis/model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "support.h"

namespace soak::anfis {
namespace {

// The unscaled parameters of the vector file in a model whose scales are 1 and 0.
Model vector_model(const nlohmann::json& v, int order) {
  Model model;
  model.order = order;
  model.x_min = -60.0;
  model.x_max = 90.0;
  for (std::size_t i = 0; i < v["a"].size(); ++i) {
    model.rules.push_back({v["a"][i], v["b"][i], v["c"][i], order == 1 ? v["consequents_slope"][i].get<double>() : 0.0,
                           v["consequents_offset"][i]});
  }
  return model;
}

// The same function with the input scaled about 15 by 75 and the output about -0.05 by 0.4.
Model rescaled(Model model) {
  const double centre = 15.0, half_range = 75.0, out_centre = -0.05, out_half_range = 0.4;
  for (Rule& rule : model.rules) {
    rule.offset = (rule.offset + rule.gain * centre - out_centre) / out_half_range;
    rule.gain = rule.gain * half_range / out_half_range;
    rule.width /= half_range;
    rule.centre = (rule.centre - centre) / half_range;
  }
  model.input_centre = centre;
  model.input_half_range = half_range;
  model.output_centre = out_centre;
  model.output_half_range = out_half_range;
  return model;
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

Model two_rules(Membership membership, double slope) {
  Model model;
  model.membership = membership;
  model.rules = {{0.1, slope, -1.0, 2.0, 0.5}, {0.1, slope, 1.0, -3.0, 0.25}};
  model.x_min = -1.0;
  model.x_max = 1.0;
  return model;
}

TEST(Model, GaussianStrengthsAreThoseOfTheFormula) {
  Model model = two_rules(Membership::gaussian, 0.0);
  model.rules[0].width = 0.8;
  model.rules[1].width = 0.5;
  std::vector<double> strengths(2);
  firing_strengths(model, 0.2, strengths);
  const double first = std::exp(-0.5 * 1.2 * 1.2 / (0.8 * 0.8));
  const double second = std::exp(-0.5 * 0.8 * 0.8 / (0.5 * 0.5));
  EXPECT_NEAR(strengths[0], first / (first + second), 1e-15);
  EXPECT_NEAR(strengths[1], second / (first + second), 1e-15);
}

TEST(Model, OnlyTheNearestRuleRemainsWhereNoneFires) {
  const Model model = two_rules(Membership::gaussian, 0.0);  // exp(-0.5 (9/0.1)^2) underflows at x = 10
  EXPECT_DOUBLE_EQ(evaluate(model, 10.0), -3.0 * 10.0 + 0.25);
  EXPECT_DOUBLE_EQ(evaluate(model, -10.0), 2.0 * -10.0 + 0.5);
}

TEST(Model, BellStrengthsKeepTheirRatioFarOut) {
  Model model = two_rules(Membership::bell, 60.0);
  std::vector<double> strengths(2);
  firing_strengths(model, 1e4, strengths);  // (1e5)^-120 underflows; the ratio tends to ((x-1)/(x+1))^120
  const double ratio = std::pow((1e4 - 1.0) / (1e4 + 1.0), 120.0);
  EXPECT_NEAR(strengths[0], ratio / (1.0 + ratio), 1e-12);
  EXPECT_NEAR(strengths[0] + strengths[1], 1.0, 1e-15);
}

TEST(Model, IsFiniteForEveryFiniteInput) {
  for (const Model& model : {two_rules(Membership::gaussian, 0.0), two_rules(Membership::bell, 2.0),
                             two_rules(Membership::bell, 1e3), rescaled(two_rules(Membership::bell, 2.0))}) {
    for (const double size : {0.0, 1e-320, 1e-8, 1.0, 30.0, 1e8, 1e154, 1e300, std::numeric_limits<double>::max()}) {
      for (const double x : {size, -size, 1.0 + size, -1.0 - size}) {
        EXPECT_TRUE(std::isfinite(evaluate(model, x))) << x;
      }
    }
  }
}

TEST(Model, RefusesWhatItCannotEvaluateAndNamesTheField) {
  const auto where_of = [](auto&& change) {
    Model model = two_rules(Membership::bell, 2.0);
    change(model);
    const auto status = validate(model);
    return status ? std::string("accepted") : status.error().where;
  };
  EXPECT_EQ(where_of([](Model&) {}), "accepted");
  EXPECT_EQ(where_of([](Model& m) { m.rules[1].centre = std::nan(""); }), "rules[1]");
  EXPECT_EQ(where_of([](Model& m) { m.rules[0].width = 0.0; }), "rules[0]");
  EXPECT_EQ(where_of([](Model& m) { m.membership = Membership::gaussian; }), "rules[0]");
  EXPECT_EQ(where_of([](Model& m) { m.order = 0; }), "rules[0]");
  EXPECT_EQ(where_of([](Model& m) { m.order = 2; }), "order");
  EXPECT_EQ(where_of([](Model& m) { m.rules.clear(); }), "rules");
  EXPECT_EQ(where_of([](Model& m) { m.input_half_range = 0.0; }), "input_half_range, output_half_range");
  EXPECT_EQ(where_of([](Model& m) { m.output_centre = HUGE_VAL; }), "input_centre, output_centre");
  EXPECT_EQ(where_of([](Model& m) { m.x_min = 2.0; }), "x_min, x_max");
}

}  // namespace
}  // namespace soak::anfis
