// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/projected_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "anfis/linear/least_squares.h"
#include "anfis/premises/premise_bounds.h"
#include "base/random.h"
#include "sample_models.h"
#include "support.h"

namespace soak::anfis::training {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// E at these premises, with the consequents solved anew.
double error_at(const std::vector<double>& theta, const Model& model, const TrainingData& data, double smoothness) {
  Model moved = model;
  set_premises(theta, moved);
  ProjectedProblem problem(moved, data, smoothness);
  EXPECT_TRUE(std::isfinite(problem.solve()));
  return problem.error();
}

// Differences of E with h = 1e-5: truncation h^2/6 E''' and rounding 1e-15 E/h (E itself loses a few digits to the
// condition of the least squares). Both are 1e-6 of the gradient's size or less on these problems.
void expect_gradient(const Model& model, const TrainingData& data, double smoothness, const std::string& what) {
  constexpr double kStep = 1e-5;
  ProjectedProblem problem(model, data, smoothness);
  problem.solve();
  std::vector<double> theta(premise_count(model)), gradient(theta.size());
  problem.gradient(gradient);
  read_premises(model, theta);
  VectorXd difference(static_cast<Index>(theta.size()));
  for (std::size_t p = 0; p < theta.size(); ++p) {
    std::vector<double> low = theta, high = theta;
    low[p] -= kStep;
    high[p] += kStep;
    difference(static_cast<Index>(p)) =
        (error_at(high, model, data, smoothness) - error_at(low, model, data, smoothness)) / (2.0 * kStep);
  }
  const VectorXd got = VectorXd::Map(gradient.data(), difference.size());
  EXPECT_GT(difference.norm(), 1e-3 * problem.error()) << what;
  EXPECT_LT((got - difference).norm(), 2e-5 * difference.norm()) << what;
}

TEST(ProjectedProblem, GradientIsThatOfTheErrorWithOptimalConsequents) {
  for (const test::Sample& sample : test::all_samples()) expect_gradient(sample.model, sample.data, 0.0, sample.what);
}

TEST(ProjectedProblem, GradientKnowsWeightsAndGroups) {
  for (const double variance : {0.0, 2.5, std::numeric_limits<double>::infinity()}) {
    for (const Shape shape : kShapes) {
      test::Sample sample = test::scatter_sample(shape, TNorm::product, 1);
      for (std::size_t i = 0; i < sample.data.rows(); ++i) {
        sample.data.weight.push_back(0.5 + static_cast<double>(i % 5));
        sample.data.group.push_back(static_cast<int>(i % 3));
      }
      sample.data.group_variance = variance;
      expect_gradient(sample.model, sample.data, 0.0, sample.what + " variance " + std::to_string(variance));
    }
  }
}

TEST(ProjectedProblem, GradientKnowsThePriceOfCurvature) {
  const TrainingData data = test::drift_problem(5, 4).data;
  for (const Shape shape : {Shape::bell, Shape::gaussian}) {
    for (const int order : {0, 1}) {
      for (const double smoothness : {1e-6, 1e-3}) {
        expect_gradient(test::grid(data, 4, shape, order), data, smoothness, std::string(name(shape)));
      }
    }
  }
}

// Plain generalised least squares with the dense covariance, from the definition of E.
TEST(ProjectedProblem, ErrorIsThatOfDenseGeneralisedLeastSquares) {
  const test::DriftProblem drift = test::drift_problem(3, 4);
  const TrainingData& data = drift.data;
  const Model model = test::grid(data, 4);
  const auto n = static_cast<Index>(data.rows());
  MatrixXd v = MatrixXd::Zero(n, n), a(n, 8);
  VectorXd y(n);
  std::vector<double> strengths(4);
  for (Index i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (Index k = 0; k < n; ++k) {
      v(i, k) = data.group[row] == data.group[static_cast<std::size_t>(k)] ? data.group_variance : 0.0;
    }
    v(i, i) += 1.0 / data.weight[row];
    firing_strengths(model, data.row(row), strengths);
    const double u = model.inputs[0].scale.scaled(data.x[row]);
    for (Index k = 0; k < 4; ++k) {
      a(i, 2 * k) = strengths[static_cast<std::size_t>(k)] * u;
      a(i, 2 * k + 1) = strengths[static_cast<std::size_t>(k)];
    }
    y(i) = model.output.scaled(data.y[row]);
  }
  const MatrixXd inverse = v.inverse();
  const VectorXd x = (a.transpose() * inverse * a).ldlt().solve(a.transpose() * inverse * y);
  const VectorXd r = y - a * x;
  ProjectedProblem problem(model, data);
  const double rmse = problem.solve();
  const double expected = r.dot(inverse * r);
  // Normal equations lose the square of the condition, about 1e3; E is at its minimum, where that counts squared.
  EXPECT_NEAR(problem.error() / expected, 1.0, 1e-9);
  EXPECT_NEAR(rmse, model.output.half_range * std::sqrt(expected * 0.002 * 0.002 / static_cast<double>(n)),
              1e-9 * rmse);
  EXPECT_NEAR(problem.error_per_square_rmse() * rmse * rmse / problem.error(), 1.0, 1e-12);
}

// E with the integral of f''^2 by differences of evaluate() on a grid of its own, at two prices: the difference
// quotient in the price is the integral at the optimum (envelope theorem).
TEST(ProjectedProblem, PriceIsTheIntegralOfTheSquaredCurvature) {
  const TrainingData data = test::drift_problem(5, 4).data;
  const Model model = test::grid(data, 4);
  const double price = 1e-4, change = 1e-6;
  ProjectedProblem low(model, data, price - change), high(model, data, price + change), middle(model, data, price);
  low.solve();
  high.solve();
  middle.solve();
  double total_weight = 0.0;
  for (const double w : data.weight) total_weight += w;
  const auto f = [&](double u) {
    const Model& m = middle.model();
    return m.output.scaled(evaluate(m, m.inputs[0].scale.unscaled(u)));
  };
  constexpr int kPoints = 4000;
  const double d = 2.0 / kPoints;
  double integral = 0.0;
  for (int i = 1; i < kPoints; ++i) {
    const double u = -1.0 + i * d;
    integral += std::pow((f(u - d) - 2.0 * f(u) + f(u + d)) / (d * d), 2) * d;
  }
  // Its own grid is a quarter of a gap fine, some 80 intervals: d^2/12 f''''/f'' twice, and half an interval at the
  // ends.
  EXPECT_NEAR((high.error() - low.error()) / (2.0 * change * total_weight) / integral, 1.0, 0.05);
}

VectorXd solved(const MatrixXd& a, const VectorXd& b) {
  ConsequentSolver solver(a.rows(), a.cols());
  return solver.solve(a, b);
}

MatrixXd gaussian_matrix(Index rows, Index columns) {
  base::Random random(12, static_cast<std::uint64_t>(columns));
  return MatrixXd::NullaryExpr(rows, columns, [&](Index, Index) { return random.gaussian(); });
}

TEST(ConsequentSolver, EqualsTheGeneralSolverOnWellConditionedProblems) {
  const MatrixXd a = gaussian_matrix(48, 9);
  const VectorXd b = gaussian_matrix(48, 1);
  EXPECT_LT((solved(a, b) - solve_least_squares(a, b).coefficients).norm(), 1e-14);
}

// Rows are condensed in blocks: none, one and several of them, the last one full or not.
TEST(ConsequentSolver, EqualsTheGeneralSolverForAnyNumberOfRows) {
  for (const Index rows : {16, 504, 512, 520, 1024, 2000, 4104}) {
    const MatrixXd a = gaussian_matrix(rows, 13);
    const VectorXd b = gaussian_matrix(rows, 1);
    EXPECT_LT((solved(a, b) - solve_least_squares(a, b).coefficients).norm(), 1e-13) << rows;
  }
}

TEST(ConsequentSolver, TakesAColumnOfRoundingErrorsForZero) {
  MatrixXd a = gaussian_matrix(48, 4);
  a.col(2) *= 1e-15;
  const VectorXd b = gaussian_matrix(48, 1);
  const VectorXd x = solved(a, b);
  MatrixXd others(48, 3);
  others << a.leftCols(2), a.col(3);
  const VectorXd expected = solve_least_squares(others, b).coefficients;
  EXPECT_EQ(x(2), 0.0);
  EXPECT_LT((Eigen::Vector3d(x(0), x(1), x(3)) - expected).norm(), 1e-13);
}

// Condition c: solutions agree to c^2 * residual * 1e-16, residuals to rounding.
TEST(ConsequentSolver, EqualsTheGeneralSolverOnIllConditionedProblems) {
  for (const double close : {1e-3, 1e-6}) {
    MatrixXd a = gaussian_matrix(48, 6);
    a.col(5) = a.col(0) + a.col(1) + close * a.col(5);
    const VectorXd b = gaussian_matrix(48, 1);
    const VectorXd expected = solve_least_squares(a, b).coefficients;
    const VectorXd x = solved(a, b);
    EXPECT_LT((x - expected).norm(), 1e-15 / (close * close) * (1.0 + b.norm())) << close;
    EXPECT_NEAR((a * x - b).norm() / (a * expected - b).norm(), 1.0, 1e-9) << close;
  }
}

TEST(ConsequentSolver, GivesTheSolutionOfLeastNormWhereColumnsDepend) {
  MatrixXd a = gaussian_matrix(48, 5);
  a.col(4) = a.col(0) - a.col(2);
  a = (a * a.colwise().norm().cwiseInverse().asDiagonal()).eval();
  const VectorXd b = gaussian_matrix(48, 1);
  const VectorXd x = solved(a, b);
  EXPECT_LT((x - solve_least_squares(a, b).coefficients).norm(), 1e-12);
  EXPECT_LT(x.norm(), 10.0 * b.norm());
  a.col(3).setZero();
  EXPECT_LT((solved(a, b) - solve_least_squares(a, b).coefficients).norm(), 1e-12);
}

TEST(ConsequentSolver, DoesNotDependOnTheUnitsOfAColumn) {
  const MatrixXd a = gaussian_matrix(48, 3);
  const VectorXd b = gaussian_matrix(48, 1);
  const Eigen::Vector3d units(1e-4, 1.0, 1e5);  // a column below 1e-10 of the largest counts as zero
  EXPECT_LT((units.asDiagonal() * solved(a * units.asDiagonal(), b) - solved(a, b)).norm(), 1e-13);
}

TEST(ConsequentSolver, GivesWhatIsNotFiniteForDataThatAreNot) {
  MatrixXd a = gaussian_matrix(48, 3);
  a(7, 1) = std::nan("");
  EXPECT_FALSE(solved(a, VectorXd::Ones(48)).allFinite());
  EXPECT_FALSE(solved(gaussian_matrix(48, 3), VectorXd::Constant(48, HUGE_VAL)).allFinite());
}

}  // namespace
}  // namespace soak::anfis::training
