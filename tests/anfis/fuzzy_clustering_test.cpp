// SPDX-License-Identifier: Apache-2.0
// Fuzzy clustering: what it finds, repeats and refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "anfis/select/detail/gath_geva.h"
#include "anfis/select/fuzzy_clustering.h"
#include "base/random.h"
#include "tests/anfis/fuzzy_clustering_support.h"

namespace soak::anfis {
namespace {

using namespace clustering_support;

/// Three lines with steps between them: slope and offset over [0, 1), [1, 2) and [2, 3).
constexpr double kSlope[] = {2.0, -3.0, 1.0};
constexpr double kOffset[] = {1.0, 8.0, -4.0};

TrainingData three_lines(std::uint64_t seed, int rows, double noise) {
  TrainingData data;
  base::Random random(seed);
  for (int k = 0; k < rows; ++k) {
    const double x = 3.0 * (k + 0.5) / rows;
    const int piece = static_cast<int>(x);
    data.x.push_back(x);
    data.y.push_back(kSlope[piece] * x + kOffset[piece] + noise * random.gaussian());
  }
  return data;
}

double slope_in_units(const Clustering& clustering, std::size_t cluster) {
  return clustering.clusters[cluster].gains(0) * clustering.output.half_range / clustering.inputs[0].half_range;
}

double value_at(const Clustering& clustering, std::size_t cluster, double x) {
  const Cluster& c = clustering.clusters[cluster];
  return clustering.output.unscaled(c.gains(0) * clustering.inputs[0].scaled(x) + c.offset);
}

void expect_equal(const Clustering& a, const Clustering& b, double tolerance) {
  ASSERT_EQ(a.clusters.size(), b.clusters.size());
  for (std::size_t i = 0; i < a.clusters.size(); ++i) {
    EXPECT_NEAR(a.clusters[i].prior, b.clusters[i].prior, tolerance);
    EXPECT_LE((a.clusters[i].centre - b.clusters[i].centre).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_LE((a.clusters[i].variance - b.clusters[i].variance).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_LE((a.clusters[i].gains - b.clusters[i].gains).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_NEAR(a.clusters[i].offset, b.clusters[i].offset, tolerance);
    EXPECT_NEAR(a.clusters[i].output_variance, b.clusters[i].output_variance, tolerance);
  }
}

TEST(FuzzyClustering, FindsTheLinesOfAPiecewiseLinearSystem) {
  const double noise = 0.02;
  ClusteringOptions options;
  options.clusters = 3;
  const auto clustering = cluster_takagi_sugeno(three_lines(1, 600, noise), options);
  ASSERT_TRUE(clustering);
  ASSERT_EQ(clustering->clusters.size(), 3U);
  EXPECT_EQ(clustering->summary.stop, ClusteringStop::converged) << clustering->summary.one_line();
  for (std::size_t i = 0; i < 3; ++i) {
    // A line through 200 points over length 1: the slope has standard error noise / (sqrt(200) sqrt(1/12)) = 0.0049,
    // its middle noise / sqrt(200) = 0.0014. Five of each; steps of more than 1 leave no row in doubt.
    const double middle = static_cast<double>(i) + 0.5;
    EXPECT_NEAR(slope_in_units(*clustering, i), kSlope[i], 0.025);
    EXPECT_NEAR(value_at(*clustering, i, middle), kSlope[i] * middle + kOffset[i], 0.007);
    const Cluster& cluster = clustering->clusters[i];
    EXPECT_NEAR(cluster.prior, 1.0 / 3.0, 1e-3);
    EXPECT_NEAR(clustering->inputs[0].unscaled(cluster.centre(0)), middle, 1e-2);
    // Uniform over length 1: variance 1/12, less 1/200^2.
    EXPECT_NEAR(cluster.variance(0) * std::pow(clustering->inputs[0].half_range, 2), 1.0 / 12.0, 1e-3);
    // A variance from 200 rows has relative standard error sqrt(2/200) = 0.1.
    EXPECT_NEAR(std::sqrt(cluster.output_variance) * clustering->output.half_range, noise, 5.0 * 0.05 * noise);
  }
}

TEST(FuzzyClustering, FindsPlanesOfTwoInputsExactlyWhereThereIsNoNoise) {
  TrainingData data;
  data.inputs = 2;
  base::Random random(4);
  for (int k = 0; k < 400; ++k) {
    const double a = random.uniform(-1.0, 1.0);
    const double b = random.uniform(-1.0, 1.0);
    data.x.insert(data.x.end(), {a, b});
    data.y.push_back(a < 0.0 ? 5.0 + 2.0 * a - b : -5.0 - a + 3.0 * b);
  }
  ClusteringOptions options;
  options.clusters = 2;
  const auto clustering = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(clustering);
  ASSERT_EQ(clustering->clusters.size(), 2U);
  const double truth[2][2] = {{2.0, -1.0}, {-1.0, 3.0}};
  for (std::size_t i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const double gain = clustering->clusters[i].gains(j) * clustering->output.half_range /
                          clustering->inputs[static_cast<std::size_t>(j)].half_range;
      // The planes are more than 3 apart and sigma is at its floor, 0.001 of the spread of y (about 5): foreign rows
      // weigh exp(-3^2 / (2 0.005^2)) = 0, what remains is rounding.
      EXPECT_NEAR(gain, truth[i][j], 1e-9);
    }
  }
}

TEST(FuzzyClustering, StopsAtTheToleranceOrAtTheLimitAndSaysWhich) {
  const TrainingData data = smooth_surface(3, 300);
  ClusteringOptions options;
  options.iterations = 2;
  const auto limited = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(limited);
  EXPECT_EQ(limited->summary.stop, ClusteringStop::iterations_done);
  EXPECT_EQ(limited->summary.log_likelihood.size(), 2U);
  EXPECT_NE(limited->summary.one_line().find("iterations done after 2"), std::string::npos);
  options.iterations = 5000;
  const auto converged = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(converged);
  EXPECT_EQ(converged->summary.stop, ClusteringStop::converged);
  EXPECT_LT(converged->summary.log_likelihood.size(), 5000U);
  // Where it stopped, one more round changes nothing beyond the tolerance.
  options.iterations = 1;
  const auto again = refine_clusters(data, *converged, options);
  ASSERT_TRUE(again);
  EXPECT_LE((again->memberships - converged->memberships).cwiseAbs().maxCoeff(), options.tolerance);
}

TEST(FuzzyClustering, MoreStartsFindNothingLessLikely) {
  const TrainingData data = smooth_surface(6, 300);
  double before = -std::numeric_limits<double>::infinity();
  for (const int starts : {1, 3, 10}) {
    ClusteringOptions options;
    options.clusters = 6;
    options.starts = starts;
    const auto clustering = cluster_takagi_sugeno(data, options);
    ASSERT_TRUE(clustering);
    EXPECT_LE(clustering->summary.start, starts);
    EXPECT_GE(clustering->summary.log_likelihood.back(), before);
    before = clustering->summary.log_likelihood.back();
  }
}

TEST(FuzzyClustering, TheSameSeedGivesTheSameBits) {
  const TrainingData data = smooth_surface(9, 200);
  ClusteringOptions options;
  options.seed = 5;
  const auto a = cluster_takagi_sugeno(data, options);
  const auto b = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(a && b);
  expect_equal(*a, *b, 0.0);
  options.seed = 6;
  options.starts = 1;
  const auto c = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(c);
  EXPECT_NE(c->summary.log_likelihood.front(), a->summary.log_likelihood.front());
}

TEST(FuzzyClustering, AWeightOfTwoIsTheSameAsARowGivenTwice) {
  TrainingData weighted = smooth_surface(11, 120);
  TrainingData repeated;
  repeated.inputs = 2;
  for (std::size_t k = 0; k < 120; ++k) {
    weighted.weight[k] = k % 3 == 0 ? 2.0 : 1.0;
    for (int copy = 0; copy < (k % 3 == 0 ? 2 : 1); ++copy) {
      repeated.x.insert(repeated.x.end(), weighted.row(k).begin(), weighted.row(k).end());
      repeated.y.push_back(weighted.y[k]);
    }
  }
  ClusteringOptions options;
  options.iterations = 10;
  const auto initial = cluster_takagi_sugeno(weighted, options);
  ASSERT_TRUE(initial);
  const auto a = refine_clusters(weighted, *initial, options);
  const auto b = refine_clusters(repeated, *initial, options);
  ASSERT_TRUE(a && b);
  // Ten rounds of sums in another order: rounding times the growth of a difference per round (about 1, at rest).
  expect_equal(*a, *b, 1e-9);
}

TEST(FuzzyClustering, OnlyRatiosOfWeightsCount) {
  TrainingData data = smooth_surface(12, 100);
  const auto a = cluster_takagi_sugeno(data);
  for (double& w : data.weight) w *= 0x1p40;
  const auto b = cluster_takagi_sugeno(data);
  ASSERT_TRUE(a && b);
  expect_equal(*a, *b, 0.0);
}

TEST(FuzzyClustering, FreeGroupOffsetsDoNotBecomeClusters) {
  TrainingData data = three_lines(2, 600, 0.02);
  data.group_variance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 600; ++k) {
    data.group.push_back(k % 4);
    data.y[static_cast<std::size_t>(k)] += 30.0 * (k % 4);
  }
  ClusteringOptions options;
  options.clusters = 3;
  const auto clustering = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(clustering);
  ASSERT_EQ(clustering->clusters.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    // As without offsets, but for what they are misjudged by: rows of a group lie alike over x, so that all groups'
    // residuals from the plane have the same mean up to noise / sqrt(150) and to the spacing 0.005 of rows times the
    // slopes and steps; the slope of a line does not change with it. Standard error as above.
    EXPECT_NEAR(slope_in_units(*clustering, i), kSlope[i], 0.03);
  }
}

TEST(FuzzyClustering, ClustersThatCannotCarryALocalModelAreDroppedAndCounted) {
  const TrainingData data = three_lines(3, 15, 0.1);
  ClusteringOptions options;
  options.clusters = 9;  // 15 rows carry at most five local models of three rows
  const auto clustering = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(clustering);
  EXPECT_GE(clustering->summary.dropped, 4);
  EXPECT_EQ(static_cast<int>(clustering->clusters.size()) + clustering->summary.dropped, 9);
  EXPECT_TRUE(clustering->memberships.allFinite());
  EXPECT_LE((clustering->memberships.rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-14);
}

TEST(FuzzyClustering, GivenClustersFarFromEveryRowAreDropped) {
  const TrainingData data = three_lines(4, 300, 0.05);
  ClusteringOptions options;
  options.clusters = 3;
  auto initial = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(initial);
  const double likelihood = initial->summary.log_likelihood.back();
  for (int copy = 0; copy < 2; ++copy) {  // several at once: each is left with a membership of exactly 0
    initial->clusters.push_back(initial->clusters[0]);
    initial->clusters.back().offset = 1e3;
  }
  const auto refined = refine_clusters(data, *initial, options);
  ASSERT_TRUE(refined);
  EXPECT_EQ(refined->clusters.size(), 3U);
  EXPECT_EQ(refined->summary.dropped, 2);
  EXPECT_EQ(refined->summary.start, 0);
  // The start had converged: one more round moves the mean log-likelihood by the order of the tolerance.
  EXPECT_NEAR(refined->summary.log_likelihood.back(), likelihood, 1e-3);
}

TEST(FuzzyClustering, OneClusterIsTheLinearModel) {
  const TrainingData data = three_lines(3, 4, 0.1);
  ClusteringOptions options;
  options.clusters = 1;
  const auto clustering = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(clustering);
  ASSERT_EQ(clustering->clusters.size(), 1U);
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    x += data.x[k] / 4.0;
    y += data.y[k] / 4.0;
    xx += data.x[k] * data.x[k] / 4.0;
    xy += data.x[k] * data.y[k] / 4.0;
  }
  EXPECT_NEAR(slope_in_units(*clustering, 0), (xy - x * y) / (xx - x * x), 1e-12);
}

TEST(FuzzyClustering, DuplicatedRowsAndConstantOutputStayFinite) {
  TrainingData data;
  for (int k = 0; k < 60; ++k) {
    data.x.push_back(k % 3);
    data.y.push_back(7.0);
  }
  ClusteringOptions options;
  options.clusters = 3;
  const auto clustering = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(clustering);
  for (std::size_t i = 0; i < clustering->clusters.size(); ++i) {
    EXPECT_GT(clustering->clusters[i].variance(0), 0.0);
    EXPECT_GT(clustering->clusters[i].output_variance, 0.0);
    EXPECT_NEAR(value_at(*clustering, i, clustering->inputs[0].unscaled(clustering->clusters[i].centre(0))), 7.0, 1e-9);
  }
}

TEST(FuzzyClustering, VariancesKeepToTheirFloors) {
  const TrainingData data = three_lines(5, 300, 0.0);
  ClusteringOptions options;
  options.clusters = 3;
  options.input_variance_floor = 0.5;
  options.output_variance_floor = 0.25;
  const auto clustering = cluster_takagi_sugeno(data, options);
  ASSERT_TRUE(clustering);
  double mean = 0.0, squares = 0.0;
  for (const double y : data.y) mean += y / 300.0;
  for (const double y : data.y) squares += (y - mean) * (y - mean) / 300.0;
  const double x_variance = 9.0 / 12.0 * (1.0 - 1.0 / (300.0 * 300.0));
  for (const Cluster& cluster : clustering->clusters) {
    EXPECT_GE(cluster.variance(0) * std::pow(clustering->inputs[0].half_range, 2), 0.5 * x_variance * (1.0 - 1e-12));
    EXPECT_GE(cluster.output_variance * std::pow(clustering->output.half_range, 2), 0.25 * squares * (1.0 - 1e-12));
  }
}

TEST(FuzzyClustering, RefusesDataThatItCannotCluster) {
  TrainingData data = smooth_surface(1, 20);
  ClusteringOptions options;
  options.clusters = 21;
  EXPECT_FALSE(cluster_takagi_sugeno(data, options)) << "fewer rows than clusters";
  options.clusters = 2;
  options.antecedents = {2};
  EXPECT_EQ(cluster_takagi_sugeno(data, options).error().where, "antecedents");
  options.antecedents = {1, 0};
  EXPECT_EQ(cluster_takagi_sugeno(data, options).error().where, "antecedents");
  options.antecedents = {};
  data.y[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(cluster_takagi_sugeno(data, options).error().where, "row 4");
  data.y[4] = 0.0;
  for (std::size_t k = 0; k < 20; ++k) data.x[2 * k + 1] = 3.0;
  EXPECT_EQ(cluster_takagi_sugeno(data, options).error().where, "x");
}

TEST(FuzzyClustering, OptionsOutOfRangeAreNamed) {
  const auto where = [](auto change) {
    ClusteringOptions options;
    change(options);
    const auto status = options.validate();
    return status ? std::string("accepted") : status.error().where;
  };
  EXPECT_TRUE(ClusteringOptions{}.validate());
  EXPECT_EQ(where([](auto& o) { o.clusters = 0; }), "clusters");
  EXPECT_EQ(where([](auto& o) { o.clusters = 257; }), "clusters");
  EXPECT_EQ(where([](auto& o) { o.input_variance_floor = 0.0; }), "input_variance_floor");
  EXPECT_EQ(where([](auto& o) { o.output_variance_floor = 1.5; }), "output_variance_floor");
  EXPECT_EQ(where([](auto& o) { o.output_variance_floor = std::nan(""); }), "output_variance_floor");
  EXPECT_EQ(where([](auto& o) { o.iterations = 0; }), "iterations");
  EXPECT_EQ(where([](auto& o) { o.tolerance = 0.0; }), "tolerance");
  EXPECT_EQ(where([](auto& o) { o.starts = 0; }), "starts");
}

}  // namespace
}  // namespace soak::anfis
