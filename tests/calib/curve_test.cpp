// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "anfis/model/one_input.h"
#include "calib/curve/calibration.h"

namespace soak::calib {
namespace {

TEST(Curve, SplineOfACubicIsThatCubic) {
  // 2 + 3 T - T^2 / 2 + T^3 / 10, written about the left knot of each of two pieces
  const auto cubic = [](double t) { return 2.0 + 3.0 * t - t * t / 2.0 + t * t * t / 10.0; };
  const auto about = [&](double k) {
    return std::array<double, 4>{cubic(k), 3.0 - k + 0.3 * k * k, -0.5 + 0.3 * k, 0.1};
  };
  const Curve curve = SplineCurve{{-4.0, 1.0, 6.0}, {about(-4.0), about(1.0)}};
  for (double t = -4.0; t <= 6.0; t += 0.125) EXPECT_NEAR(evaluate(curve, t), cubic(t), 1e-12);
}

TEST(Curve, SplineTakesTheRightPieceAtAKnot) {
  const Curve steps = SplineCurve{{0.0, 1.0, 2.0}, {{10.0, 0.0, 0.0, 0.0}, {20.0, 0.0, 0.0, 0.0}}};
  EXPECT_EQ(evaluate(steps, std::nextafter(1.0, 0.0)), 10.0);
  EXPECT_EQ(evaluate(steps, 1.0), 20.0);
  EXPECT_EQ(evaluate(steps, 2.0), 20.0);
}

TEST(Curve, TableIsLinearBetweenItsPoints) {
  const Curve curve = TableCurve{-10.0, 5.0, {1.0, 3.0, -1.0}};
  EXPECT_DOUBLE_EQ(evaluate(curve, -10.0), 1.0);
  EXPECT_DOUBLE_EQ(evaluate(curve, -9.0), 1.4);
  EXPECT_DOUBLE_EQ(evaluate(curve, -5.0), 3.0);
  EXPECT_DOUBLE_EQ(evaluate(curve, -2.5), 1.0);
  EXPECT_DOUBLE_EQ(evaluate(curve, 0.0), -1.0);
}

TEST(Curve, TableOfOnePointIsConstant) {
  const Curve curve = TableCurve{20.0, 1.0, {0.25}};
  for (const double t : {-100.0, 20.0, 100.0}) EXPECT_EQ(evaluate(curve, t), 0.25);
}

TEST(Curve, EveryKindHoldsItsEndsOutsideItsDomain) {
  // one rule: the output is its consequent, here u = x
  anfis::Model model = anfis::curve_model(anfis::Shape::bell, {{{1.0, 2.0, 0.0, 1.0, 0.0}}});
  model.inputs[0].max = 10.0;
  const Curve curves[] = {model, SplineCurve{{0.0, 10.0}, {{0.0, 1.0, 0.0, 0.0}}}, TableCurve{0.0, 10.0, {0.0, 10.0}}};
  for (const Curve& curve : curves) {
    EXPECT_DOUBLE_EQ(evaluate(curve, -5.0), 0.0);
    EXPECT_DOUBLE_EQ(evaluate(curve, 4.0), 4.0);
    EXPECT_DOUBLE_EQ(evaluate(curve, 15.0), 10.0);
  }
}

TEST(Curve, ManyTemperaturesGiveWhatEachGivesAlone) {
  anfis::Model model =
      anfis::curve_model(anfis::Shape::gaussian, {{{0.5, 0.0, -1.0, 0.3, 1.0}, {0.4, 0.0, 1.0, -2.0, 0.0}}});
  model.inputs[0].scale = {20.0, 50.0};
  model.inputs[0].min = -30.0;
  model.inputs[0].max = 70.0;
  const Curve curves[] = {model, SplineCurve{{0.0, 10.0}, {{1.0, 1.0, 0.5, -0.1}}},
                          TableCurve{0.0, 5.0, {0.0, 7.0, 3.0}}};
  const std::vector<double> temps_c = {70.0, -40.0, 0.0, 3.75, 80.0, 10.0};
  for (const Curve& curve : curves) {
    std::vector<double> values(temps_c.size());
    evaluate(curve, temps_c, values);
    for (std::size_t i = 0; i < temps_c.size(); ++i) EXPECT_EQ(values[i], evaluate(curve, temps_c[i])) << i;
  }
}

}  // namespace
}  // namespace soak::calib
