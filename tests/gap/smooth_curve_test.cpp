// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base/smooth_curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"

namespace soak::calib::gap {
namespace {

constexpr Eigen::Index kCount = 21;
constexpr double kNoise = 0.001;

std::vector<double> plateaus() {
  std::vector<double> level_c;
  for (Eigen::Index k = 0; k < kCount; ++k) level_c.push_back(-30.0 + 5.0 * static_cast<double>(k));
  return level_c;
}

Eigen::VectorXd values(double (*curve)(double)) {
  Eigen::VectorXd result(kCount);
  for (Eigen::Index k = 0; k < kCount; ++k) result(k) = curve(plateaus()[static_cast<std::size_t>(k)]);
  return result;
}

Eigen::MatrixXd noise_covariance() { return kNoise * kNoise * Eigen::MatrixXd::Identity(kCount, kCount); }

/// A spike at one level.
Eigen::MatrixXd spike_at(Eigen::Index k) {
  Eigen::MatrixXd shape = Eigen::MatrixXd::Zero(kCount, 1);
  shape(k, 0) = 1.0;
  return shape;
}

TEST(SmoothCurve, KnowsTheHeightOfASpikeOnAGentleCurveToTheNoise) {
  Eigen::VectorXd levels = values([](double c) { return 0.5 * std::atan((c - 20.0) / 35.0); });
  levels(9) += 0.05;
  const FeatureFit fit = SmoothCurve(plateaus(), levels, noise_covariance()).with_each(spike_at(9)).front();
  EXPECT_NEAR(fit.height, 0.05, 2.0 * kNoise);
  EXPECT_GT(fit.squared_ratio, 400.0);
  EXPECT_GT(fit.length_c, 15.0);
}

TEST(SmoothCurve, TrustsNoSpikeOnACurveThatIsWavyBetweenItsLevels) {
  Eigen::VectorXd levels = values([](double c) { return 0.05 * std::sin(c / 2.7); });
  levels(9) += 0.05;
  const FeatureFit fit = SmoothCurve(plateaus(), levels, noise_covariance()).with_each(spike_at(9)).front();
  EXPECT_LT(fit.squared_ratio, 10.0);
}

TEST(SmoothCurve, LeavesAStraightShapeToTheCurve) {
  Eigen::MatrixXd straight(kCount, 1);
  for (Eigen::Index k = 0; k < kCount; ++k) straight(k, 0) = 3.0 - 0.1 * static_cast<double>(k);
  const Eigen::VectorXd levels = values([](double c) { return 0.01 * c + 0.1 * std::cos(c / 20.0); });
  const FeatureFit fit = SmoothCurve(plateaus(), levels, noise_covariance()).with_each(straight).front();
  EXPECT_EQ(fit.height, 0.0);
  EXPECT_EQ(fit.squared_ratio, 0.0);
}

TEST(SmoothCurve, HoldsTheFeatureThatIsThereForLikelierThanAnother) {
  Eigen::VectorXd levels =
      values([](double c) { return 0.3 * std::atan((c - 20.0) / 35.0) + 0.01 * std::max(0.0, c - 15.0); });
  Eigen::MatrixXd shapes(kCount, 2);
  for (Eigen::Index k = 0; k < kCount; ++k) {
    const double c = plateaus()[static_cast<std::size_t>(k)];
    shapes(k, 0) = std::max(0.0, c - 15.0);
    shapes(k, 1) = c == 15.0 ? 1.0 : 0.0;
  }
  const std::vector<FeatureFit> fits = SmoothCurve(plateaus(), levels, noise_covariance()).with_each(shapes);
  EXPECT_GT(fits[0].log_likelihood, fits[1].log_likelihood + 10.0);
  EXPECT_NEAR(fits[0].height, 0.01, 0.001);
}

TEST(SmoothCurve, StatesTheErrorOfTheHeightOfCurvesOfAnyScale) {
  // Curves as sums of many waves of one shortest length, which is another way to draw a process of that kind.
  base::Random random(5);
  int inside = 0;
  constexpr int kCurves = 200;
  for (int i = 0; i < kCurves; ++i) {
    const double length_c = 10.0 * std::pow(6.0, random.uniform());
    Eigen::VectorXd levels = Eigen::VectorXd::Zero(kCount);
    for (int wave = 0; wave < 60; ++wave) {
      const double frequency = random.gaussian() / length_c;
      const double phase = 6.283185307179586 * random.uniform();
      for (Eigen::Index k = 0; k < kCount; ++k) {
        levels(k) += 0.03 * std::cos(frequency * plateaus()[static_cast<std::size_t>(k)] + phase);
      }
    }
    for (double& level : levels) level += kNoise * random.gaussian();
    levels(7) += 0.02;
    const FeatureFit fit = SmoothCurve(plateaus(), levels, noise_covariance()).with_each(spike_at(7)).front();
    const double sigma = std::abs(fit.height) / std::sqrt(fit.squared_ratio);
    if (std::abs(fit.height - 0.02) < 2.12 * sigma) ++inside;  // Student's t, 16 degrees of freedom
  }
  EXPECT_GE(inside, kCurves * 90 / 100);
  EXPECT_LE(inside, kCurves * 99 / 100);
}

}  // namespace
}  // namespace soak::calib::gap
