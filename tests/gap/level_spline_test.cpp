// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base/base_curve.h"

#include <gtest/gtest.h>

#include <cmath>

namespace soak::calib::gap {
namespace {

const std::vector<double> kKnots = {-20.0, -4.0, 11.0, 25.0, 41.0, 70.0};

double value(const LevelSpline& spline, const Eigen::VectorXd& levels, double x) {
  return spline.weights(x).dot(levels);
}

TEST(LevelSpline, TakesTheValuesOfItsKnots) {
  const LevelSpline spline(kKnots);
  for (std::size_t k = 0; k < kKnots.size(); ++k) {
    const Eigen::RowVectorXd weights = spline.weights(kKnots[k]);
    for (Eigen::Index j = 0; j < weights.size(); ++j) {
      EXPECT_NEAR(weights(j), j == static_cast<Eigen::Index>(k) ? 1.0 : 0.0, 1e-12);
    }
  }
}

TEST(LevelSpline, FollowsStraightLinesAlsoBeyondItsEnds) {
  const LevelSpline spline(kKnots);
  Eigen::VectorXd line(6);
  for (Eigen::Index k = 0; k < 6; ++k) line(k) = 3.0 - 0.25 * kKnots[static_cast<std::size_t>(k)];
  for (const double x : {-35.0, -20.0, -7.3, 0.0, 33.3, 70.0, 81.0}) {
    EXPECT_NEAR(value(spline, line, x), 3.0 - 0.25 * x, 1e-10);
    EXPECT_NEAR(spline.slope_weights(x).dot(line), -0.25, 1e-10);
  }
}

// Natural spline through (0, 0), (1, 1), (2, 0): 1.5 x − 0.5 x³ on the first piece.
TEST(LevelSpline, IsTheNaturalSplineOfThreePoints) {
  const LevelSpline spline({0.0, 1.0, 2.0});
  const Eigen::Vector3d levels(0.0, 1.0, 0.0);
  for (const double x : {0.0, 0.25, 0.5, 0.9, 1.0}) {
    EXPECT_NEAR(value(spline, levels, x), 1.5 * x - 0.5 * x * x * x, 1e-12);
    EXPECT_NEAR(spline.slope_weights(x).dot(levels), 1.5 - 1.5 * x * x, 1e-12);
    EXPECT_NEAR(value(spline, levels, 2.0 - x), value(spline, levels, x), 1e-12);
  }
}

TEST(LevelSpline, OfOneKnotIsAConstant) {
  const LevelSpline spline({25.0});
  EXPECT_EQ(spline.weights(60.0)(0), 1.0);
  EXPECT_EQ(spline.slope_weights(60.0)(0), 0.0);
}

}  // namespace
}  // namespace soak::calib::gap
