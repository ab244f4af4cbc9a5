// SPDX-License-Identifier: Apache-2.0
// Fuzzy clustering against its equations, put down plainly.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "anfis/select/detail/gath_geva.h"
#include "anfis/select/fuzzy_clustering.h"
#include "base/random.h"
#include "tests/anfis/fuzzy_clustering_support.h"

namespace soak::anfis {
namespace {

using namespace clustering_support;

struct Problem {
  fuzzy::ScaledRows rows;
  Eigen::MatrixXd memberships;
};

Problem random_problem() {
  const TrainingData data = smooth_surface(7, 60);
  Problem problem{fuzzy::scaled_rows(data, fuzzy::scales_of(data)), Eigen::MatrixXd(60, 3)};
  base::Random random(8);
  for (int k = 0; k < 60; ++k) {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += problem.memberships(k, i) = random.uniform(0.05, 1.0);
    problem.memberships.row(k) /= sum;
  }
  return problem;
}

constexpr double kNoFloor = 1e-12;
const fuzzy::VarianceFloors kNoFloors{Eigen::Vector2d::Constant(kNoFloor), kNoFloor};

TEST(FuzzyClustering, CentresVariancesAndLocalModelsFollowTheirEquations) {
  const Problem problem = random_problem();
  const auto& rows = problem.rows;
  for (int i = 0; i < 3; ++i) {
    const Cluster cluster = fuzzy::cluster_of(rows, problem.memberships.col(i), kNoFloors);
    double mass = 0.0;
    double total = 0.0;
    for (int k = 0; k < 60; ++k) {
      mass += rows.weight(k) * problem.memberships(k, i);
      total += rows.weight(k);
    }
    EXPECT_NEAR(cluster.prior, mass / total, 1e-14);
    // eq. 5.27
    for (int j = 0; j < 2; ++j) {
      double centre = 0.0;
      for (int k = 0; k < 60; ++k) centre += rows.weight(k) * problem.memberships(k, i) * rows.x(k, j) / mass;
      double variance = 0.0;
      for (int k = 0; k < 60; ++k) {
        variance += rows.weight(k) * problem.memberships(k, i) * std::pow(rows.x(k, j) - centre, 2) / mass;
      }
      EXPECT_NEAR(cluster.centre(j), centre, 1e-13);
      EXPECT_NEAR(cluster.variance(j), variance, 1e-13);
    }
    // eq. 5.30: theta solves (phi^T beta phi) theta = phi^T beta y; and eq. 5.31
    double squares = 0.0;
    double normal[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 60; ++k) {
      const double beta = rows.weight(k) * problem.memberships(k, i);
      const double r = rows.y(k) - cluster.gains(0) * rows.x(k, 0) - cluster.gains(1) * rows.x(k, 1) - cluster.offset;
      normal[0] += beta * r * rows.x(k, 0);
      normal[1] += beta * r * rows.x(k, 1);
      normal[2] += beta * r;
      squares += beta * r * r;
    }
    for (const double equation : normal) EXPECT_NEAR(equation, 0.0, 1e-12);
    EXPECT_NEAR(cluster.output_variance, squares / mass, 1e-13);
  }
}

TEST(FuzzyClustering, DistancesAndMembershipsFollowTheCorrectedEquations) {
  const Problem problem = random_problem();
  const auto& rows = problem.rows;
  std::vector<Cluster> clusters;
  for (int i = 0; i < 3; ++i) clusters.push_back(fuzzy::cluster_of(rows, problem.memberships.col(i), kNoFloors));
  for (const std::vector<int>& antecedents : {std::vector<int>{0, 1}, std::vector<int>{1}}) {
    const Eigen::MatrixXd closeness = fuzzy::log_closeness(rows, clusters, antecedents);
    const fuzzy::Partition partition = fuzzy::partition(closeness, rows.weight);
    double likelihood = 0.0;
    for (int k = 0; k < 60; ++k) {
      const auto normal = [](double d, double variance) {
        return std::exp(-d * d / (2.0 * variance)) / std::sqrt(2.0 * std::numbers::pi * variance);
      };
      double d[3];  // D_ik, eq. 5.32 corrected
      double density = 0.0;
      for (std::size_t i = 0; i < 3; ++i) {
        const Cluster& c = clusters[i];
        const double f = c.gains(0) * rows.x(k, 0) + c.gains(1) * rows.x(k, 1) + c.offset;
        double inverse = c.prior * normal(rows.y(k) - f, c.output_variance);
        for (const int j : antecedents) inverse *= normal(rows.x(k, j) - c.centre(j), c.variance(j));
        EXPECT_NEAR(closeness(k, static_cast<int>(i)), std::log(inverse), 1e-12);
        d[i] = 1.0 / std::sqrt(inverse);
        density += inverse;
      }
      for (int i = 0; i < 3; ++i) {  // eq. 5.33 corrected, m = 2
        double sum = 0.0;
        for (const double other : d) sum += std::pow(d[i] / other, 2.0 / (2.0 - 1.0));
        EXPECT_NEAR(partition.memberships(k, i), 1.0 / sum, 1e-12);
      }
      likelihood += rows.weight(k) * std::log(density) / 60.0;  // weights have mean 1
    }
    EXPECT_NEAR(partition.log_likelihood, likelihood, 1e-12);
  }
}

TEST(FuzzyClustering, DistancesDoNotUnderflowFarFromEveryCluster) {
  fuzzy::ScaledRows rows{Eigen::MatrixXd(2, 1), Eigen::VectorXd::Zero(2), Eigen::VectorXd::Ones(2)};
  rows.x << 0.0, 1000.0;
  Cluster near{
      0.5, Eigen::VectorXd::Constant(1, 1.0), Eigen::VectorXd::Constant(1, 1e-4), Eigen::VectorXd::Zero(1), 0.0, 1.0};
  Cluster far = near;
  far.centre(0) = 0.9;
  const auto partition = fuzzy::partition(fuzzy::log_closeness(rows, {near, far}, {0}), rows.weight);
  // Densities near exp(-5e9): only their ratio decides.
  EXPECT_EQ(partition.memberships(1, 0), 1.0);
  EXPECT_EQ(partition.memberships(0, 1), 1.0);
  EXPECT_TRUE(std::isfinite(partition.log_likelihood));
}

TEST(FuzzyClustering, TheLikelihoodNeverFalls) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    ClusteringOptions options;
    options.clusters = 5;
    options.starts = 1;
    options.seed = seed;
    const auto clustering = cluster_takagi_sugeno(smooth_surface(seed, 300), options);
    ASSERT_TRUE(clustering);
    ASSERT_EQ(clustering->summary.dropped, 0);
    const auto& likelihood = clustering->summary.log_likelihood;
    ASSERT_GT(likelihood.size(), 3U);
    EXPECT_GT(likelihood.back(), likelihood.front());
    for (std::size_t l = 1; l < likelihood.size(); ++l) {
      // Expectation maximisation rises; rounding of a mean of 300 logarithms of order 10 is below 1e-13.
      EXPECT_GE(likelihood[l], likelihood[l - 1] - 1e-12) << "seed " << seed << " iteration " << l;
    }
  }
}

TEST(FuzzyClustering, EveryRowBelongsSomewhereAndPriorsSumToOne) {
  const auto clustering = cluster_takagi_sugeno(smooth_surface(5, 200));
  ASSERT_TRUE(clustering);
  EXPECT_EQ(clustering->memberships.rows(), 200);
  EXPECT_EQ(clustering->memberships.cols(), static_cast<Eigen::Index>(clustering->clusters.size()));
  EXPECT_GE(clustering->memberships.minCoeff(), 0.0);
  EXPECT_LE((clustering->memberships.rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-14);
  double sum = 0.0;
  for (const Cluster& cluster : clustering->clusters) sum += cluster.prior;
  EXPECT_NEAR(sum, 1.0, 1e-13);
}

}  // namespace
}  // namespace soak::anfis
