// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "base/random.h"

namespace soak::anfis {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kQuietNaN = std::numeric_limits<double>::quiet_NaN();

struct Rows {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
};

Rows random_rows(Eigen::Index rows, Eigen::Index columns) {
  base::Random random(21);
  const auto draw = [&](auto...) { return random.gaussian(); };
  return {Eigen::MatrixXd::NullaryExpr(rows, columns, draw), Eigen::VectorXd::NullaryExpr(rows, draw)};
}

SequentialLeastSquares learned(const Rows& rows, double initial_covariance, double forgetting) {
  SequentialLeastSquares solver(static_cast<std::size_t>(rows.a.cols()), initial_covariance, forgetting);
  for (Eigen::Index i = 0; i < rows.a.rows(); ++i) {
    EXPECT_TRUE(solver.update(rows.a.row(i).transpose(), rows.b(i)));
  }
  return solver;
}

// The recursion solves (sum lambda^(N-i) a_i a_i^T + (lambda^N / eta) I) X = sum lambda^(N-i) a_i b_i, and S is the
// inverse of that matrix.
TEST(SequentialLeastSquares, EqualsBatchLeastSquaresWithForgettingWeightsAndThePriorAsRidge) {
  const Rows rows = random_rows(60, 5);
  for (const double eta : {0.5, 1e3}) {
    for (const double lambda : {1.0, 0.95}) {
      Eigen::MatrixXd information = std::pow(lambda, 60) / eta * Eigen::MatrixXd::Identity(5, 5);
      Eigen::VectorXd right = Eigen::VectorXd::Zero(5);
      for (Eigen::Index i = 0; i < 60; ++i) {
        const double weight = std::pow(lambda, 59 - i);
        information += weight * rows.a.row(i).transpose() * rows.a.row(i);
        right += weight * rows.a.row(i).transpose() * rows.b(i);
      }
      const SequentialLeastSquares solver = learned(rows, eta, lambda);
      // Rounding: S starts at eta, so that its errors are about 1e-16 eta, two orders more over the rows.
      const double tolerance = 1e-13 * std::max(1.0, eta);
      EXPECT_LT((solver.coefficients() - information.llt().solve(right)).cwiseAbs().maxCoeff(), tolerance);
      EXPECT_LT((solver.covariance() - information.inverse()).cwiseAbs().maxCoeff(), tolerance);
    }
  }
}

TEST(SequentialLeastSquares, KeepsItsCovarianceExactlySymmetric) {
  const SequentialLeastSquares solver = learned(random_rows(200, 7), 1e6, 0.9);
  EXPECT_EQ(solver.covariance(), solver.covariance().transpose());
}

// One column of ones: X is the mean of b with weights lambda^(N-i). N rows of the value 1 after many of 0 make it
// 1 - lambda^N: the window is 1/(1 - lambda) rows.
TEST(SequentialLeastSquares, ForgetsAnOldValueByLambdaToTheNumberOfRowsSince) {
  const double lambda = 0.9;
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  SequentialLeastSquares solver(1, 1e6, lambda);
  for (int i = 0; i < 400; ++i) solver.update(one, 0.0);  // 0.9^400 = 5e-19: nothing is left of the prior
  EXPECT_NEAR(solver.covariance()(0, 0), 1.0 - lambda, 1e-14);
  for (int n = 1; n <= 50; ++n) {
    solver.update(one, 1.0);
    EXPECT_NEAR(solver.coefficients()(0), 1.0 - std::pow(lambda, n), 1e-13) << n;
  }
}

TEST(SequentialLeastSquares, FollowsADriftThatLeastSquaresWithoutForgettingAverages) {
  const Rows rows = random_rows(2000, 3);
  const auto worst_late_error = [&](double forgetting) {
    SequentialLeastSquares solver(3, 1e6, forgetting);
    double worst = 0.0;
    for (Eigen::Index i = 0; i < 2000; ++i) {
      const Eigen::Vector3d truth(1e-3 * static_cast<double>(i), -1.0, 2.0 - 1e-3 * static_cast<double>(i));
      solver.update(rows.a.row(i).transpose(), rows.a.row(i).dot(truth));
      if (i >= 1000) worst = std::max(worst, (solver.coefficients() - truth).norm());
    }
    return worst;
  };
  // A window of 20 rows lags a ramp by about 20 rows times its slope, 1e-3 sqrt(2); all rows alike lag by 1000 of them.
  EXPECT_LT(worst_late_error(0.95), 0.06);
  EXPECT_GT(worst_late_error(1.0), 1.0);
}

TEST(SequentialLeastSquares, RefusesRowsThatAreNotFiniteOrWouldOverflowAndKeepsItsState) {
  SequentialLeastSquares solver = learned(random_rows(10, 3), 1e6, 0.95);
  const Eigen::VectorXd coefficients = solver.coefficients();
  const Eigen::MatrixXd covariance = solver.covariance();
  const Eigen::Vector3d usual(1.0, 2.0, 3.0);
  struct Row {
    Eigen::Vector3d a;
    double b;
  };
  const std::vector<Row> refused = {{usual, kQuietNaN},
                                    {usual, -kInfinity},
                                    {{kQuietNaN, 0.0, 0.0}, 1.0},
                                    {{0.0, kInfinity, 0.0}, 1.0},
                                    {{1e200, 1e200, -1e200}, 1.0},
                                    {{1e-300, 0.0, 0.0}, std::numeric_limits<double>::max()}};
  for (std::size_t i = 0; i < refused.size(); ++i) {
    EXPECT_FALSE(solver.update(refused[i].a, refused[i].b)) << i;
    EXPECT_EQ(solver.coefficients(), coefficients) << i;
    EXPECT_EQ(solver.covariance(), covariance) << i;
  }
}

TEST(SequentialLeastSquares, BeginsAnewFromZeroOrFromGivenCoefficients) {
  const Rows rows = random_rows(30, 4);
  SequentialLeastSquares solver = learned(rows, 1e4, 1.0);
  const Eigen::VectorXd first = solver.coefficients();
  solver.restart();
  EXPECT_EQ(solver.coefficients(), Eigen::VectorXd::Zero(4));
  for (Eigen::Index i = 0; i < 30; ++i) solver.update(rows.a.row(i).transpose(), rows.b(i));
  EXPECT_EQ(solver.coefficients(), first);
  const Eigen::VectorXd given = Eigen::VectorXd::LinSpaced(4, -1.0, 1.0);
  solver.restart(given);
  EXPECT_EQ(solver.coefficients(), given);
  EXPECT_EQ(solver.covariance(), 1e4 * Eigen::MatrixXd::Identity(4, 4));
}

// Without the limit the variance of the directions that the row does not excite grows by 1/lambda per row: 0.99^-1e6
// overflows. With it a^T S a stays at the 1 - lambda of an exponential window, so that the fit goes on to follow b.
TEST(SequentialLeastSquares, NeverWindsUpOverAMillionRowsOfConstantInput) {
  const Eigen::Vector3d a(1.0, -2.0, 0.5);
  const double eta = 1e6;
  for (const double lambda : {1.0, 0.99, 0.5}) {
    SequentialLeastSquares solver(3, eta, lambda);
    double largest = 0.0;
    for (int i = 0; i < 1'000'000; ++i) {
      ASSERT_TRUE(solver.update(a, 3.0));
      largest = std::max(largest, solver.covariance().diagonal().maxCoeff());
    }
    EXPECT_LE(largest, 2.0 * eta);
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(solver.covariance()).eigenvalues().minCoeff(), 0.0);
    // S has entries of size eta, rounded to 1e-10, and as many roundings as there are rows in the window add up.
    const double window = lambda == 1.0 ? 1e6 : 1.0 / (1.0 - lambda);
    EXPECT_NEAR(a.dot(solver.covariance() * a), 1.0 / window, 1e-9 * window) << lambda;
    EXPECT_NEAR(a.dot(solver.coefficients()), 3.0, 1e-6);
    // The directions not excited never left X = 0: X is along a.
    EXPECT_LT((solver.coefficients() - a * (3.0 / a.squaredNorm())).norm(), 1e-4);
    for (int i = 0; i < 2000 && lambda < 1.0; ++i) solver.update(a, -1.0);
    if (lambda < 1.0) {
      EXPECT_NEAR(a.dot(solver.coefficients()), -1.0, 1e-6);
    }
  }
}

// Where a^T S a is lost in the rounding of eta (here 1e6 * 1e-16 against 1/|a|^2 = 1e-16) S gets negative eigenvalues.
// The rows that follow lift them again, so that the fit is still that of batch least squares, if not to all digits.
TEST(SequentialLeastSquares, StaysUsableWhereRoundingCostsItsDefiniteness) {
  Rows rows = random_rows(5000, 4);
  rows.a *= 1e8;
  rows.b = rows.a * Eigen::Vector4d(1.0, -2.0, 3.0, -4.0) + 1e7 * rows.b;
  SequentialLeastSquares solver(4, 1e6);
  bool indefinite = false;
  for (Eigen::Index i = 0; i < 5000; ++i) {
    ASSERT_TRUE(solver.update(rows.a.row(i).transpose(), rows.b(i)));
    indefinite = indefinite || rows.a.row(i).dot(solver.covariance() * rows.a.row(i).transpose()) < 0.0;
  }
  EXPECT_TRUE(indefinite);
  const Eigen::VectorXd batch = rows.a.colPivHouseholderQr().solve(rows.b);
  // The coefficients' own standard deviation is 0.1 / sqrt(5000) = 1.4e-3.
  EXPECT_LT((solver.coefficients() - batch).norm(), 1e-3);
}

}  // namespace
}  // namespace soak::anfis
