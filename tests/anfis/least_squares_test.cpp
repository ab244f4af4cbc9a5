// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "base/random.h"
#include "published_data.h"

namespace soak::anfis {
namespace {

void expect_certified(const char* name, double least_digits) {
  const test::CertifiedFit set = test::nist_linear(name);
  const LeastSquaresFit fit = solve_least_squares(set.a, set.y);
  ASSERT_EQ(fit.rank, set.a.cols());
  const double s2 = fit.residual_sum_of_squares / static_cast<double>(set.a.rows() - set.a.cols());
  for (Eigen::Index k = 0; k < set.a.cols(); ++k) {
    EXPECT_GE(test::digits(fit.coefficients(k), set.b(k)), least_digits) << name << " b" << k;
    EXPECT_GE(test::digits(std::sqrt(s2) * fit.covariance_factor.row(k).norm(), set.sd(k)), least_digits)
        << name << " sd" << k;
  }
}

TEST(LeastSquares, ReachesSevenDigitsOnFilip) { expect_certified("filip", 7.0); }
TEST(LeastSquares, ReachesSevenDigitsOnWampler4) { expect_certified("wampler4", 7.0); }

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns) {
  base::Random random(11);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&](Eigen::Index, Eigen::Index) { return random.gaussian(); });
}

TEST(LeastSquares, FindsTheRankAndTheLeastNormWhereColumnsDepend) {
  Eigen::MatrixXd a = random_matrix(20, 5);
  a.col(4) = a.col(0) - a.col(2);
  a = (a * a.colwise().norm().cwiseInverse().asDiagonal()).eval();  // unit columns: the least norm is the plain one
  const Eigen::VectorXd b = random_matrix(20, 1);
  const LeastSquaresFit fit = solve_least_squares(a, b);
  EXPECT_EQ(fit.rank, 4);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::VectorXd inverse = svd.singularValues().cwiseInverse();
  inverse(4) = 0.0;
  const Eigen::MatrixXd pseudo = svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose();
  EXPECT_LT((fit.coefficients - pseudo * b).norm(), 1e-12);
  EXPECT_LT((fit.covariance_factor * fit.covariance_factor.transpose() - pseudo * pseudo.transpose()).norm(), 1e-12);
  EXPECT_LT((least_squares_coefficients(a, b) - fit.coefficients).norm(), 1e-15);
}

TEST(LeastSquares, DoesNotDependOnTheUnitsOfAColumn) {
  const Eigen::MatrixXd a = random_matrix(15, 3);
  const Eigen::VectorXd b = random_matrix(15, 1);
  const Eigen::Vector3d units(1e-9, 1.0, 1e12);
  const LeastSquaresFit plain = solve_least_squares(a, b);
  const LeastSquaresFit scaled = solve_least_squares(a * units.asDiagonal(), b);
  EXPECT_EQ(scaled.rank, 3);
  EXPECT_LT((units.asDiagonal() * scaled.coefficients - plain.coefficients).norm(), 1e-13);
}

TEST(LeastSquares, GivesNaNInsteadOfANumberForDataThatAreNotFinite) {
  Eigen::MatrixXd a = random_matrix(6, 2);
  a(3, 1) = std::numeric_limits<double>::infinity();
  const LeastSquaresFit fit = solve_least_squares(a, Eigen::VectorXd::Ones(6));
  EXPECT_TRUE(fit.coefficients.array().isNaN().all());
  EXPECT_TRUE(std::isnan(fit.residual_sum_of_squares));
  EXPECT_LT(fit.rank, a.cols());
}

}  // namespace
}  // namespace soak::anfis
