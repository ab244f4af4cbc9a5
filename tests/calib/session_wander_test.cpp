// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/session_wander.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"

namespace soak::calib::six_position {
namespace {

constexpr Eigen::Index kRows = 24;

/// A walk of that variance in 1000 steps over the time of the rows, about its mean, read at the rows.
Eigen::VectorXd walk(double variance, base::Random& random) {
  constexpr int kSteps = 1000;
  std::vector<double> path(kSteps + 1, 0.0);
  double mean = 0.0;
  for (int i = 1; i <= kSteps; ++i) {
    path[static_cast<std::size_t>(i)] =
        path[static_cast<std::size_t>(i - 1)] + std::sqrt(variance / kSteps) * random.gaussian();
    mean += path[static_cast<std::size_t>(i)] / kSteps;
  }
  Eigen::VectorXd read(kRows);
  for (Eigen::Index i = 0; i < kRows; ++i)
    read[i] = path[static_cast<std::size_t>(std::lround(static_cast<double>(i * kSteps) / (kRows - 1)))] - mean;
  return read;
}

Eigen::VectorXd times() { return Eigen::VectorXd::LinSpaced(kRows, -1.0, 1.0); }

/// A mean, a line, and a change of face every six rows.
Eigen::MatrixXd design() {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(kRows, 5);
  columns.col(0).setOnes();
  columns.col(1) = times();
  for (Eigen::Index i = 0; i < kRows; ++i) {
    if (i >= 6) columns(i, 1 + i / 6) = 1.0;
  }
  return columns;
}

TEST(SessionWander, TheWalksCovarianceIsThatOfWalks) {
  base::Random random(1);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kRows, kRows);
  constexpr int kWalks = 4000;
  for (int n = 0; n < kWalks; ++n) {
    const Eigen::VectorXd one = walk(2.0, random);
    sum += one * one.transpose() / kWalks;
  }
  const Eigen::MatrixXd expected = 2.0 * walk_about_its_mean(times());
  EXPECT_NEAR(expected(0, 0), 2.0 / 3.0, 1e-12);
  EXPECT_LT((sum - expected).cwiseAbs().maxCoeff(), 0.08);
}

TEST(SessionWander, ItsVarianceIsFoundBesideUnknownsAndNoise) {
  base::Random random(2);
  double mean = 0.0;
  constexpr int kSessions = 400;
  const Eigen::VectorXd noise = Eigen::VectorXd::Constant(kRows, 0.01);
  for (int n = 0; n < kSessions; ++n) {
    Eigen::VectorXd y = design() * Eigen::VectorXd::LinSpaced(5, -3.0, 4.0) + walk(1.0, random);
    for (double& value : y) value += 0.1 * random.gaussian();
    const SessionWander wander = estimate_session_wander(design(), y, noise, times());
    mean += wander.variance / kSessions;
    EXPECT_GT(wander.information, 0.0);
  }
  EXPECT_NEAR(mean, 1.0, 0.1);  // its scatter from session to session is about 0.5
}

TEST(SessionWander, NoiseAloneIsMostlyNoWander) {
  base::Random random(3);
  int none = 0;
  for (int n = 0; n < 200; ++n) {
    Eigen::VectorXd y(kRows);
    for (double& value : y) value = random.gaussian();
    const auto wander = estimate_session_wander(design(), y, Eigen::VectorXd::Ones(kRows), times());
    none += wander.variance == 0.0 ? 1 : 0;
  }
  EXPECT_GT(none, 100);  // half of the scores are negative where the truth is on the border
}

TEST(SessionWander, ThreeSpareRowsAreTooFewAndNoneToo) {
  for (const Eigen::Index rows : {7, 4}) {
    const Eigen::MatrixXd columns = design().topRows(7).leftCols(4).bottomRows(rows);
    const Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(rows, 0.0, 1.0).array().square();
    EXPECT_EQ(estimate_session_wander(columns, y, Eigen::VectorXd::Ones(rows), times().head(rows)).variance, 0.0);
  }
}

}  // namespace
}  // namespace soak::calib::six_position
