// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "anfis/select/detail/compaction.h"
#include "anfis/select/fuzzy_clustering.h"
#include "base/random.h"
#include "fuzzy_support.h"

namespace soak::anfis {
namespace {

using test::determinant_of;
using test::one_bent_input;
using test::Square;

std::vector<Cluster> random_clusters(std::uint64_t seed, int count, int inputs, double spread) {
  base::Random random(seed);
  std::vector<Cluster> clusters(static_cast<std::size_t>(count));
  double sum = 0.0;
  for (Cluster& cluster : clusters) {
    sum += cluster.prior = random.uniform(0.2, 1.0);
    cluster.centre.resize(inputs);
    cluster.variance.resize(inputs);
    for (int j = 0; j < inputs; ++j) {
      cluster.centre(j) = spread * random.gaussian();
      cluster.variance(j) = random.uniform(0.1, 0.5);
    }
  }
  for (Cluster& cluster : clusters) cluster.prior /= sum;
  return clusters;
}

struct PlainCovariances {
  Square between;
  Square within;
};

/// [AH05 eq. 5.37], corrected, in loops.
PlainCovariances plain_covariances(const std::vector<Cluster>& clusters, const std::vector<int>& inputs) {
  const std::size_t n = inputs.size();
  PlainCovariances f{Square(n, std::vector<double>(n, 0.0)), Square(n, std::vector<double>(n, 0.0))};
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < n; ++c) {
      double mean_r = 0.0, mean_c = 0.0;
      for (const Cluster& cluster : clusters) mean_r += cluster.prior * cluster.centre(inputs[r]);
      for (const Cluster& cluster : clusters) mean_c += cluster.prior * cluster.centre(inputs[c]);
      for (const Cluster& cluster : clusters) {
        f.between[r][c] += cluster.prior * (cluster.centre(inputs[r]) - mean_r) * (cluster.centre(inputs[c]) - mean_c);
        f.within[r][c] += r == c ? cluster.prior * cluster.variance(inputs[r]) : 0.0;
      }
    }
  }
  return f;
}

TEST(Separability, IsTheRatioOfDeterminants) {
  for (const std::vector<int>& inputs : {std::vector<int>{0, 1, 2, 3}, std::vector<int>{1, 3}, std::vector<int>{2}}) {
    const auto clusters = random_clusters(3, 3, 4, 1.0);  // fewer clusters than inputs: det(F_B) is 0
    PlainCovariances f = plain_covariances(clusters, inputs);
    for (std::size_t r = 0; r < inputs.size(); ++r) {
      for (std::size_t c = 0; c < inputs.size(); ++c) f.between[r][c] += f.within[r][c];
    }
    EXPECT_NEAR(fuzzy::log_separability(fuzzy::class_covariances(clusters), inputs),
                std::log(determinant_of(f.between) / determinant_of(f.within)), 1e-12);
  }
}

TEST(Separability, TendsToThePrintedCriterionWhereClustersLieFarApart) {
  const std::vector<int> inputs = {0, 1, 2};
  const auto clusters = random_clusters(4, 8, 3, 1e4);
  const PlainCovariances f = plain_covariances(clusters, inputs);
  const double printed = std::log(determinant_of(f.between) / determinant_of(f.within));
  // log det(F_B + F_W) - log det(F_B) is about tr(F_B^-1 F_W), of order 3 / 1e8.
  EXPECT_NEAR(fuzzy::log_separability(fuzzy::class_covariances(clusters), inputs), printed, 1e-6);
}

TEST(Separability, BetweenAndWithinSumToTheTotalVarianceOfTheRows) {
  const TrainingData data = one_bent_input(2);
  ClusteringOptions options;
  options.tolerance = 1e-9;  // so that clusters are those of the final memberships
  options.iterations = 3000;
  const auto clustering = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(clustering);
  const auto f = fuzzy::class_covariances(clustering->clusters);
  for (std::size_t j = 0; j < 4; ++j) {
    double mean = 0.0, squares = 0.0;
    for (std::size_t k = 0; k < data.rows(); ++k) mean += clustering->inputs[j].scaled(data.row(k)[j]) / 400.0;
    for (std::size_t k = 0; k < data.rows(); ++k) {
      squares += std::pow(clustering->inputs[j].scaled(data.row(k)[j]) - mean, 2) / 400.0;
    }
    const auto i = static_cast<Eigen::Index>(j);
    EXPECT_NEAR(f.between(i, i) + f.within(i), squares, 1e-12);
  }
}

TEST(Separability, NeverFallsWithAnInputAndCountsARepeatedOneForWhatItAdds) {
  auto clusters = random_clusters(6, 5, 3, 1.0);
  for (Cluster& cluster : clusters) {
    cluster.centre(2) = cluster.centre(1);
    cluster.variance(2) = cluster.variance(1);
  }
  const auto f = fuzzy::class_covariances(clusters);
  const double first = fuzzy::log_separability(f, {1});
  const double both = fuzzy::log_separability(f, {1, 2});
  EXPECT_GT(both, first);
  EXPECT_LT(both, 2.0 * first);
  EXPECT_GE(fuzzy::log_separability(f, {0, 1, 2}), both);
  // 1 and 2 are each other's replacement: one of them is the least needed, the last among equals.
  EXPECT_EQ(fuzzy::least_needed(f, {0, 1, 2}), 2);
}

}  // namespace
}  // namespace soak::anfis
