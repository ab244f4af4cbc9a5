// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/condensed_rows.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "anfis/linear/least_squares.h"
#include "anfis/select/structure_search.h"
#include "anfis/select/uncertainty.h"
#include "anfis/train/learner.h"
#include "base/random.h"
#include "curves.h"
#include "support.h"

namespace soak::anfis {
namespace {

constexpr int kRuns = 5;
const std::vector<double> kTemps = {-30.0, -10.0, 5.0, 20.0, 45.0, 70.0};

double flat(double) { return 0.0; }

/// Runs that share their temperatures, up and down, but not all of them, with weights of their own.
TrainingData unbalanced_runs() {
  base::Random random(3);
  TrainingData data;
  data.group_variance = 0.04;
  for (int run = 0; run < kRuns; ++run) {
    for (int visit = 0; visit < 12; ++visit) {
      if ((run + visit) % 4 == 0) continue;
      data.x.push_back(kTemps[static_cast<std::size_t>(visit < 6 ? visit : 11 - visit)]);
      data.y.push_back(std::sin(data.x.back() / 20.0) + 0.1 * run + 0.05 * random.gaussian());
      data.weight.push_back(100.0 * random.uniform(1.0, 9.0));
      data.group.push_back(run);
    }
  }
  return data;
}

/// r^T V^-1 r with V written out.
double squares_by_dense_covariance(const TrainingData& data, const Eigen::VectorXd& r) {
  Eigen::MatrixXd v = Eigen::MatrixXd::Zero(r.size(), r.size());
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    const auto a = static_cast<std::size_t>(i);
    for (Eigen::Index k = 0; k < r.size(); ++k) {
      const auto b = static_cast<std::size_t>(k);
      v(i, k) = (i == k ? 1.0 / data.weight[a] : 0.0) + (data.group[a] == data.group[b] ? data.group_variance : 0.0);
    }
  }
  return r.dot(v.inverse() * r);
}

TEST(CondensedRows, AnyCurveErrsOnThemAsOnAllRows) {
  const TrainingData data = unbalanced_runs();
  const auto condensed = condense(data, 0.0, flat);
  ASSERT_TRUE(condensed) << condensed.error().message;
  const TrainingData& rows = *condensed;
  EXPECT_EQ(rows.x, kTemps);
  EXPECT_EQ(rows.measured_rows(), data.rows());
  base::Random random(4);
  for (int curve = 0; curve < 10; ++curve) {
    Eigen::VectorXd f(6);
    for (double& value : f) value = random.gaussian();
    Eigen::VectorXd r(static_cast<Eigen::Index>(data.rows()));
    for (std::size_t i = 0; i < data.rows(); ++i) {
      const auto k = std::find(kTemps.begin(), kTemps.end(), data.x[i]) - kTemps.begin();
      r(static_cast<Eigen::Index>(i)) = data.y[i] - f(k);
    }
    Eigen::VectorXd left = Eigen::Map<const Eigen::VectorXd>(rows.y.data(), 6) - f;
    GroupWhitening(rows).apply(left);
    const double expected = squares_by_dense_covariance(data, r);
    EXPECT_NEAR(left.squaredNorm() + rows.squares_within, expected, 1e-10 * expected);
  }
}

TEST(CondensedRows, MoveAlongTheShapeToTheMiddleOfTheirInputs) {
  const auto shape = [](double x) { return std::sin(x) + 0.1 * x * x; };
  TrainingData data;
  base::Random random(5);
  for (int i = 0; i < 60; ++i) {
    data.x.push_back(static_cast<double>(i % 6) + 0.2 * random.uniform());
    data.y.push_back(shape(data.x.back()));
  }
  const TrainingData rows = condense(data, 0.5, shape).value();
  ASSERT_EQ(rows.rows(), 6U);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(rows.y[k], shape(rows.x[k]), 1e-14);
  EXPECT_NEAR(rows.squares_within, 0.0, 1e-25);
}

TEST(CondensedRows, TeachTheSameCurveWithTheSameBandAsAllRows) {
  TrainingData data = test::drift_problem(2, 6).data;
  for (double& x : data.x) x = 5.0 * std::round(x / 5.0);
  const Model all = test::learn_curve(data, 5, Shape::gaussian);
  const TrainingData rows = condense(data, 0.0, flat).value();
  const Model few = test::learn_curve(rows, 5, Shape::gaussian);
  const auto band = PredictionVariance::of(few, rows, 1e-7).value();
  const auto expected = PredictionVariance::of(all, data, 1e-7).value();
  EXPECT_NEAR(band.degrees_of_freedom(), expected.degrees_of_freedom(), 0.1);
  for (double x = -30.0; x <= 70.0; x += 2.5) {
    // The scatter of a row is 0.002.
    EXPECT_NEAR(evaluate(few, x), evaluate(all, x), 2e-5) << x;
    EXPECT_NEAR(std::sqrt(band.at(x)), std::sqrt(expected.at(x)), 0.02 * std::sqrt(expected.at(x))) << x;
  }
}

TEST(CondensedRows, AreRefusedWhereTheyAreNotWholeOrWouldHaveToBeSplit) {
  const TrainingData rows = condense(unbalanced_runs(), 0.0, flat).value();
  EXPECT_TRUE(validate(rows, 0));
  TrainingData short_factor = rows;
  short_factor.precision_factor.pop_back();
  EXPECT_EQ(validate(short_factor, 0).error().where, "precision_factor");
  TrainingData not_finite = rows;
  not_finite.precision_factor[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(validate(not_finite, 0).error().where, "precision_factor");
  const std::vector<int> fold = {0, 1, 0, 1, 0, 1};
  EXPECT_EQ(search_structure(rows, fold, {}).error().where, "precision_factor");
}

TEST(CondensedRows, AreRefusedWhereTheyCannotBeMade) {
  TrainingData data = unbalanced_runs();
  EXPECT_EQ(condense(data, -1.0, flat).error().where, "width");
  EXPECT_EQ(condense(condense(data, 0.0, flat).value(), 0.0, flat).error().where, "precision_factor");
  data.group_variance = std::numeric_limits<double>::infinity();
  EXPECT_EQ(condense(data, 0.0, flat).error().where, "group_variance");
  EXPECT_EQ(condense({{0.0, 1.0, 2.0, 3.0}, {1.0, 2.0}, {}, {}, 0.0, 2, {}, 0.0, 0}, 0.0, flat).error().where, "x");
}

// What is left of the runs' level beside such offsets is rounding, by which a pivot of the factorisation may be
// negative.
TEST(CondensedRows, AreRefusedWhereOffsetsDwarfTheNoise) {
  TrainingData data = unbalanced_runs();
  int refused = 0;
  for (double variance = 1e12; variance < 1e30; variance *= 10.0) {
    data.group_variance = variance;
    const auto rows = condense(data, 0.0, flat);
    if (rows) {
      EXPECT_TRUE(validate(*rows, 0)) << variance;
      continue;
    }
    EXPECT_EQ(rows.error().where, "group_variance") << variance;
    ++refused;
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace soak::anfis
