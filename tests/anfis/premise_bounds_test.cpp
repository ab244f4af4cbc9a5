// SPDX-License-Identifier: Apache-2.0
#include "anfis/premises/premise_bounds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anfis/model/one_input.h"
#include "base/random.h"
#include "sample_models.h"

namespace soak::anfis::training {
namespace {

/// 21 plateaus from -1 to 1; the model's scales are 1.
TrainingData plateaus() {
  TrainingData data;
  for (int i = 0; i <= 20; ++i) data.x.push_back(-1.0 + 0.1 * i);
  data.y.assign(data.x.size(), 0.0);
  return data;
}

Model three_rules(Shape shape) {
  const double slope = shape == Shape::bell ? 1.0 : 0.0;
  return curve_model(shape, std::vector<CurveRule>{{0.4, 1.7 * slope, -0.8, 0.7, -0.2},
                                                   {0.3, 2.2 * slope, 0.1, -1.1, 0.4},
                                                   {0.5, 3.1 * slope, 0.9, 0.2, 0.6}});
}

/// The model after the bounds of three_rules(), whose memberships rise.
Model applied(Model model, const TrainingData& data, PremiseLimits limits = PremiseLimits::resolved) {
  const PremiseBounds bounds(three_rules(Shape::bell), data, limits);
  bounds.apply(model);
  return model;
}

const std::array<double, 4>& parameters(const Model& model, std::size_t k) {
  return model.inputs[0].memberships[k].parameters;
}

TEST(PremiseBounds, KeepMembershipsAsWideAsTheGapsBetweenInputs) {
  for (const Shape shape : {Shape::bell, Shape::gaussian}) {
    const PremiseBounds bounds(three_rules(shape), plateaus());
    Model model = three_rules(shape);
    model.inputs[0].memberships[1].parameters[0] = 1e-9;
    if (shape == Shape::bell) model.inputs[0].memberships[0].parameters[1] = 50.0;
    bounds.apply(model);
    EXPECT_NEAR(parameters(model, 1)[0], 0.1, 1e-12);
    if (shape == Shape::bell) {
      EXPECT_NEAR(parameters(model, 1)[1], 1.0, 1e-9);  // edge width/slope >= 0.1
      EXPECT_NEAR(parameters(model, 0)[1], 4.0, 1e-9);
    }
  }
}

TEST(PremiseBounds, KeepFlanksAsLongAsTheGapsBetweenInputs) {
  Model model = three_rules(Shape::gaussian);
  model.inputs[0].memberships = {{Shape::triangle, {-0.81, -0.8, 9.0}},
                                 {Shape::trapezoid, {0.0999, 0.1, 0.2, 0.2001}},
                                 {Shape::two_sided_gaussian, {1e-3, 0.6, 9.0, 0.8}}};
  model = applied(model, plateaus());
  EXPECT_NEAR(parameters(model, 0)[0], -0.9, 1e-12);
  EXPECT_NEAR(parameters(model, 0)[2], -0.8 + 4.0, 1e-12);  // no longer than 4 half ranges
  EXPECT_NEAR(parameters(model, 1)[0], 0.0, 1e-12);
  EXPECT_NEAR(parameters(model, 1)[3], 0.3, 1e-12);
  EXPECT_NEAR(parameters(model, 2)[0], 0.1, 1e-12);
  EXPECT_EQ(parameters(model, 2)[2], 4.0);
  EXPECT_EQ(parameters(model, 2)[1], 0.6);
}

TEST(PremiseBounds, AskForWiderMembershipsWhereInputsAreSparse) {
  TrainingData data = plateaus();
  data.x.erase(data.x.begin() + 14, data.x.begin() + 17);  // nothing between 0.3 and 0.7
  data.y.resize(data.x.size());
  const PremiseBounds bounds(three_rules(Shape::gaussian), data);
  EXPECT_NEAR(bounds.interval(0, gaussian(0.2, 0.5), 0).low, 0.4, 1e-12);
  EXPECT_NEAR(bounds.interval(0, gaussian(0.2, -0.5), 0).low, 0.1, 1e-12);
}

TEST(PremiseBounds, OfOrderedLimitsLookPastTheGaps) {
  Model model = three_rules(Shape::bell);
  model.inputs[0].memberships[1].parameters = {1e-9, 50.0, 5.0, 0.0};
  model.inputs[0].memberships[0].parameters[1] = 1e-3;
  const Model ordered = applied(model, plateaus(), PremiseLimits::ordered);
  EXPECT_LE(parameters(ordered, 1)[0], 0.02);
  EXPECT_GT(parameters(ordered, 1)[0], 0.0);
  EXPECT_LE(parameters(ordered, 1)[1], 16.0);
  EXPECT_EQ(parameters(ordered, 0)[1], 0.25);
  EXPECT_LE(parameters(ordered, 1)[2], 1.0);
  EXPECT_LT(parameters(ordered, 1)[2], parameters(ordered, 2)[2]);
}

TEST(PremiseBounds, OfNoLimitsLeaveEverythingAlone) {
  Model model = three_rules(Shape::bell);
  model.inputs[0].memberships[1].parameters = {1e-9, 50.0, 5.0, 0.0};
  EXPECT_EQ(applied(model, plateaus(), PremiseLimits::none), model);
  std::vector<double> descent(9, -1.0);
  PremiseBounds(model, plateaus(), PremiseLimits::none).block(model, descent);
  EXPECT_EQ(descent, std::vector<double>(9, -1.0));
}

TEST(PremiseBounds, KeepCentresInOrderInsideTheData) {
  Model model = three_rules(Shape::gaussian);
  const PremiseBounds bounds(model, plateaus());
  const double moved[] = {5.0, -3.0, 0.99};
  for (std::size_t k = 0; k < 3; ++k) model.inputs[0].memberships[k].parameters[1] = moved[k];
  bounds.apply(model);
  EXPECT_LE(parameters(model, 2)[1], 1.0);
  EXPECT_GE(parameters(model, 0)[1], -1.0);
  EXPECT_NEAR(parameters(model, 1)[1] - parameters(model, 0)[1], 0.05, 1e-12);
  EXPECT_NEAR(parameters(model, 2)[1] - parameters(model, 1)[1], 0.05, 1e-12);
}

TEST(PremiseBounds, OrderOnlyMembershipsThatRulesShare) {
  test::Sample grid = test::grid_sample(Shape::gaussian, TNorm::product, 1);
  test::Sample scatter = test::scatter_sample(Shape::gaussian, TNorm::product, 1);
  EXPECT_TRUE(PremiseBounds(grid.model, grid.data).ordered(0));
  EXPECT_TRUE(PremiseBounds(grid.model, grid.data).ordered(1));
  EXPECT_FALSE(PremiseBounds(scatter.model, scatter.data).ordered(0));
  EXPECT_TRUE(PremiseBounds(three_rules(Shape::bell), plateaus()).ordered(0));
}

TEST(PremiseBounds, LeaveAdmissiblePremisesAlone) {
  EXPECT_EQ(applied(three_rules(Shape::bell), plateaus()), three_rules(Shape::bell));
}

/// A sample whose premises were thrown about.
Model scrambled(Model model, base::Random& random) {
  std::vector<double> theta(premise_count(model));
  read_premises(model, theta);
  for (double& value : theta) value += random.gaussian();
  set_premises(theta, model);
  return model;
}

bool all_inside(const PremiseBounds& bounds, const Model& model, double tolerance) {
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    for (const Membership& m : model.inputs[j].memberships) {
      for (std::size_t p = 0; p < parameter_count(m.shape); ++p) {
        const Interval interval = bounds.interval(j, m, p);
        if (m.parameters[p] < interval.low - tolerance || m.parameters[p] > interval.high + tolerance) return false;
      }
    }
  }
  return true;
}

TEST(PremiseBounds, MakeValidAdmissiblePremisesOfAny) {
  base::Random random(3);
  for (const test::Sample& sample : test::all_samples()) {
    for (const PremiseLimits limits : {PremiseLimits::resolved, PremiseLimits::ordered}) {
      const PremiseBounds bounds(sample.model, sample.data, limits);
      for (int i = 0; i < 20; ++i) {
        Model model = scrambled(sample.model, random);
        bounds.apply(model);
        ASSERT_TRUE(validate(model)) << sample.what << ' ' << validate(model).error().where;
        EXPECT_TRUE(all_inside(bounds, model, 1e-12)) << sample.what;
      }
    }
  }
}

// A projection: applied twice it is the same as once.
TEST(PremiseBounds, LeaveAloneWhatTheyHaveMade) {
  base::Random random(4);
  for (const test::Sample& sample : test::all_samples()) {
    const PremiseBounds bounds(sample.model, sample.data);
    double moved = 0.0;
    for (int i = 0; i < 20; ++i) {
      Model model = scrambled(sample.model, random);
      bounds.apply(model);
      std::vector<double> once(premise_count(model)), twice(once.size());
      read_premises(model, once);
      bounds.apply(model);
      read_premises(model, twice);
      for (std::size_t p = 0; p < once.size(); ++p) moved = std::max(moved, std::abs(once[p] - twice[p]));
    }
    EXPECT_LT(moved, 1e-12) << sample.what;
  }
}

TEST(PremiseBounds, KeepNeighboursApartForEveryShape) {
  base::Random random(5);
  for (const Shape shape : kShapes) {
    const test::Sample sample = test::grid_sample(shape, TNorm::product, 1);
    const PremiseBounds bounds(sample.model, sample.data);
    double closest = HUGE_VAL;
    for (int i = 0; i < 50; ++i) {
      Model model = scrambled(sample.model, random);
      bounds.apply(model);
      for (std::size_t j = 0; j < 2; ++j) {
        const auto& memberships = model.inputs[j].memberships;
        for (std::size_t k = 1; k < memberships.size(); ++k) {
          closest = std::min(closest, centre(memberships[k]) - centre(memberships[k - 1]) - bounds.separation(j));
        }
      }
    }
    EXPECT_GT(closest, -1e-12) << name(shape);
  }
}

TEST(PremiseBounds, BlockOnlyDirectionsThatLeaveTheBorder) {
  Model model = three_rules(Shape::gaussian);
  const PremiseBounds bounds(model, plateaus());
  model.inputs[0].memberships[0].parameters[1] = -1.0;
  model.inputs[0].memberships[1].parameters[0] = bounds.interval(0, model.inputs[0].memberships[1], 0).low;
  std::vector<double> out(6, -1.0);  // width, centre of each membership
  bounds.block(model, out);
  EXPECT_EQ(out, (std::vector<double>{-1.0, 0.0, 0.0, -1.0, -1.0, -1.0}));
  std::vector<double> in(6, 1.0);
  bounds.block(model, in);
  EXPECT_EQ(in, std::vector<double>(6, 1.0));
}

TEST(InputGaps, AreTheWidestNearby) {
  const InputGaps gaps({0.0, 1.0, 0.5, 0.5, 0.1, 3.0});
  EXPECT_EQ(gaps.lowest(), 0.0);
  EXPECT_EQ(gaps.highest(), 3.0);
  EXPECT_EQ(gaps.widest(), 2.0);
  EXPECT_EQ(gaps.near(2.0), 2.0);
  EXPECT_EQ(gaps.near(-0.5), 2.0);  // the gap of 2 begins at 1.0, within -0.5 + 2
  EXPECT_EQ(gaps.near(-1.6), 0.4);  // those above 0.5 do not reach to 0.4
  EXPECT_EQ(gaps.near(-9.0), 2.0);  // where no gap is near, the widest
}

}  // namespace
}  // namespace soak::anfis::training
