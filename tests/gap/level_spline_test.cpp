// SPDX-License-Identifier: Apache-2.0
// The base's curve, and what the base takes off.
#include "calib/gap/base/base_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "calib/gap/base/campaign_model.h"
#include "tests/gap/made_up_campaign.h"

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

TEST(LevelSpline, GivesEachOfManyTheWeightsOfOne) {
  const std::vector<double> x = {-35.0, -20.0, -7.3, 11.0, 33.3, 70.0, 81.0};
  for (const LevelSpline& spline : {LevelSpline(kKnots), LevelSpline({-5.0, 40.0}), LevelSpline({25.0})}) {
    const Eigen::MatrixXd many = spline.weights(x);
    ASSERT_EQ(many.rows(), 7);
    for (Eigen::Index i = 0; i < many.rows(); ++i) {
      EXPECT_EQ(many.row(i), spline.weights(x[static_cast<std::size_t>(i)])) << i;
      EXPECT_NEAR(many.row(i).sum(), 1.0, 1e-12) << i;
    }
  }
}

TEST(LevelSpline, OfOneKnotIsAConstant) {
  const LevelSpline spline({25.0});
  EXPECT_EQ(spline.weights(60.0)(0), 1.0);
  EXPECT_EQ(spline.slope_weights(60.0)(0), 0.0);
}

// The normal equations of least squares, also where columns depend on each other: without the first run the offsets of
// the others say what the levels do, and the offset of another run that is left out has no readings.
TEST(CampaignModel, LeavesNothingAlongWhatIsFreeInTheBaseWhateverRunIsLeftOut) {
  made_up::Plan plan;
  plan.runs = 3;
  const auto campaign = made_up::campaign(plan, made_up::nothing());
  const Observations observations = observe(campaign);
  const TemperatureHistory history(campaign, observations);
  for (const std::optional<int> left_out : {std::optional<int>(), std::optional(0), std::optional(2)}) {
    const CampaignModel model(observations, history, left_out);
    for (const Sensor sensor : kSensors) {
      const SensorResidual& residual = model.residuals().sensor[index_of(sensor)].value();
      std::vector<double> temp_c;
      for (const Observation& row : observations.rows) temp_c.push_back(row.sensor_temp_c[index_of(sensor)]);
      const BaseDesign design = base_design(observations, sensor, temp_c);
      const Eigen::MatrixXd white = residual.whiten(design.columns);
      for (Eigen::Index k = 0; k < white.cols(); ++k) {
        if (k >= design.levels && k < 2 * design.levels) continue;  // slopes have a prior
        const double most = white.col(k).norm() * residual.residual().norm();
        EXPECT_LE(std::abs(white.col(k).dot(residual.residual())), 1e-7 * most) << name_of(sensor) << " column " << k;
        EXPECT_LE(residual.project(white.col(k)).norm(), 1e-7 * white.col(k).norm())
            << name_of(sensor) << " column " << k;
      }
    }
  }
}

}  // namespace
}  // namespace soak::calib::gap
