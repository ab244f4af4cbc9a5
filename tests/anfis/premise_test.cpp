// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "anfis/training/premise_bounds.h"
#include "anfis/training/premise_layer.h"
#include "anfis/training/trainer.h"
#include "support.h"

namespace soak::anfis::training {
namespace {

std::vector<Rule> some_rules(Membership membership) {
  const bool bell = membership == Membership::bell;
  return {{0.4, bell ? 1.7 : 0.0, -0.8, 0.7, -0.2},
          {0.3, bell ? 2.2 : 0.0, 0.1, -1.1, 0.4},
          {0.5, bell ? 3.1 : 0.0, 0.9, 0.2, 0.6}};
}

const std::vector<double> kInputs = {-1.0, -0.83, -0.8, -0.4, 0.0, 0.1, 0.33, 0.9, 1.0};  // centres among them

double* parameter(Rule& rule, Membership membership, int kind) {
  if (membership == Membership::gaussian && kind == 1) {
    return &rule.centre;
  }
  return kind == 0 ? &rule.width : kind == 1 ? &rule.slope : &rule.centre;
}

TEST(PremiseLayer, EveryPremiseDerivativeAgreesWithDifferences) {
  for (const Membership membership : {Membership::bell, Membership::gaussian}) {
    std::vector<Rule> rules = some_rules(membership);
    PremiseLayer layer(kInputs);
    layer.compute(membership, rules);
    const Eigen::MatrixXd jacobian = layer.premise_jacobian(membership, rules);
    ASSERT_EQ(jacobian.cols(), 3 * premises_per_rule(membership));
    for (int kind = 0; kind < premises_per_rule(membership); ++kind) {
      for (std::size_t i = 0; i < rules.size(); ++i) {
        const double h =
            1e-5;  // central difference: truncation h^2 f'''/6 ~ 1e-8 with f''' ~ 1e3 at the narrowest rule
        std::vector<Rule> low = rules, high = rules;
        *parameter(low[i], membership, kind) -= h;
        *parameter(high[i], membership, kind) += h;
        layer.compute(membership, high);
        Eigen::VectorXd difference = layer.output(high);
        layer.compute(membership, low);
        difference = ((difference - layer.output(low)) / (2.0 * h)).eval();
        const Eigen::Index column = kind * 3 + static_cast<Eigen::Index>(i);
        EXPECT_GT(difference.norm(), 1e-3);
        EXPECT_LT((jacobian.col(column) - difference).cwiseAbs().maxCoeff(), 1e-7) << name(membership) << kind << i;
      }
    }
  }
}

TEST(PremiseLayer, ConsequentMatrixTimesConsequentsIsTheOutputOfTheModel) {
  for (const Membership membership : {Membership::bell, Membership::gaussian}) {
    Model model;
    model.membership = membership;
    model.rules = some_rules(membership);
    PremiseLayer layer(kInputs);
    layer.compute(membership, model.rules);
    Eigen::VectorXd x(6);
    x << 0.7, -1.1, 0.2, -0.2, 0.4, 0.6;
    const Eigen::VectorXd y = layer.consequent_matrix(1) * x;
    for (std::size_t i = 0; i < kInputs.size(); ++i) {
      EXPECT_NEAR(y(static_cast<Eigen::Index>(i)), evaluate(model, kInputs[i]), 1e-14);
    }
  }
}

// E as a function of the premises alone: with the consequents solved anew, as the gradient claims that they add
// nothing.
TEST(Trainer, GradientIsThatOfTheErrorWithOptimalConsequents) {
  TrainingData data = test::drift_problem(5, 4).data;
  for (const Membership membership : {Membership::bell, Membership::gaussian}) {
    HybridOptions options;
    options.rules = 4;
    options.membership = membership;
    Trainer trainer(data, options);
    trainer.solve_consequents();
    const Model model = trainer.model();
    const std::vector<Rule> gradient = trainer.gradient();
    // A step against one component of the gradient alone: E changes by -step |component| for a small one. The trainer
    // moves against all, so E must fall by step * norm to first order.
    double norm = 0.0;
    for (const Rule& g : gradient) {
      norm += g.width * g.width + g.slope * g.slope + g.centre * g.centre;
    }
    norm = std::sqrt(norm);
    const auto error = [&](double step) {
      Trainer moved(data, options);
      moved.solve_consequents();
      EXPECT_TRUE(moved.move_premises(step));
      const double rmse = moved.solve_consequents();
      double total = 0.0;
      for (const double w : data.weight) {
        total += w;
      }
      return rmse * rmse * total / (model.output_half_range * model.output_half_range);
    };
    Trainer fresh(data, options);
    const double rmse = fresh.solve_consequents();
    const double start =
        rmse * rmse * 4.0 * 21.0 / (0.002 * 0.002) / (model.output_half_range * model.output_half_range);
    // Centres on the ends of the range are blocked outwards; only descent that is free counts.
    std::vector<Rule> descent = gradient;
    double free_norm = norm * norm;
    for (std::size_t i : {std::size_t{0}, descent.size() - 1}) {
      const bool outward = i == 0 ? descent[i].centre > 0.0 : descent[i].centre < 0.0;
      free_norm -= outward ? descent[i].centre * descent[i].centre : 0.0;
    }
    const double h = 1e-6;
    EXPECT_NEAR((start - error(h)) / h / std::sqrt(free_norm), 1.0, 1e-3) << name(membership);
  }
}

std::vector<double> plateaus() {
  std::vector<double> u;
  for (int i = 0; i <= 20; ++i) {
    u.push_back(-1.0 + 0.1 * i);
  }
  return u;
}

TEST(PremiseBounds, KeepMembershipsAsWideAsTheGapsBetweenInputs) {
  for (const Membership membership : {Membership::bell, Membership::gaussian}) {
    const PremiseBounds bounds(membership, plateaus(), 3);
    std::vector<Rule> rules = some_rules(membership);
    rules[1].width = 1e-9;
    rules[0].slope = membership == Membership::bell ? 50.0 : 0.0;
    bounds.apply(rules);
    EXPECT_NEAR(rules[1].width, 0.1, 1e-12);
    if (membership == Membership::bell) {
      EXPECT_NEAR(rules[1].slope, 1.0, 1e-9);  // edge width/slope >= 0.1
      EXPECT_NEAR(rules[0].slope, 4.0, 1e-9);
    }
  }
}

TEST(PremiseBounds, AskForWiderMembershipsWhereInputsAreSparse) {
  std::vector<double> inputs = plateaus();
  inputs.erase(inputs.begin() + 14, inputs.begin() + 17);  // nothing between 0.3 and 0.7
  const PremiseBounds bounds(Membership::gaussian, inputs, 3);
  EXPECT_NEAR(bounds.least_width(0.5), 0.4, 1e-12);
  EXPECT_NEAR(bounds.least_width(-0.5), 0.1, 1e-12);
}

TEST(PremiseBounds, KeepCentresInOrderInsideTheData) {
  const PremiseBounds bounds(Membership::gaussian, plateaus(), 3);
  std::vector<Rule> rules = some_rules(Membership::gaussian);
  rules[0].centre = 5.0;
  rules[1].centre = -3.0;
  rules[2].centre = 0.99;
  bounds.apply(rules);
  EXPECT_LE(rules[2].centre, 1.0);
  EXPECT_GE(rules[0].centre, -1.0);
  EXPECT_NEAR(rules[1].centre - rules[0].centre, 0.05, 1e-12);
  EXPECT_NEAR(rules[2].centre - rules[1].centre, 0.05, 1e-12);
}

TEST(PremiseBounds, LeaveAdmissiblePremisesAlone) {
  const PremiseBounds bounds(Membership::bell, plateaus(), 3);
  std::vector<Rule> rules = some_rules(Membership::bell);
  const std::vector<Rule> before = rules;
  bounds.apply(rules);
  EXPECT_EQ(rules, before);
}

TEST(PremiseBounds, BlockOnlyDirectionsThatLeaveTheBorder) {
  const PremiseBounds bounds(Membership::gaussian, plateaus(), 3);
  std::vector<Rule> rules = some_rules(Membership::gaussian);
  rules[0].centre = -1.0;
  rules[1].width = 0.1;
  std::vector<Rule> out(3, Rule{-1.0, 0.0, -1.0, 0.0, 0.0});
  bounds.block(rules, out);
  EXPECT_EQ(out[0].centre, 0.0);
  EXPECT_EQ(out[1].width, 0.0);
  EXPECT_EQ(out[0].width, -1.0);
  EXPECT_EQ(out[1].centre, -1.0);
  std::vector<Rule> in(3, Rule{1.0, 0.0, 1.0, 0.0, 0.0});
  bounds.block(rules, in);
  EXPECT_EQ(in[0].centre, 1.0);
  EXPECT_EQ(in[1].width, 1.0);
}

}  // namespace
}  // namespace soak::anfis::training
