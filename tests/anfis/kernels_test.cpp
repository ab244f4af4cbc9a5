// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "anfis/model/detail/inference.h"
#include "base/random.h"
#include "kernels_baseline.h"

namespace soak::anfis::training {
namespace {

constexpr std::size_t kRows = 136;  // 17 times kLanes

std::vector<double> random_column(std::uint64_t stream, double low, double high) {
  base::Random random(3, stream);
  std::vector<double> column(kRows);
  for (double& value : column) value = random.uniform(low, high);
  return column;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

struct Columns {
  std::vector<double> distance = std::vector<double>(kRows);
  std::vector<double> degree = std::vector<double>(kRows);
};

// Inputs of usual size, one on the centre, and some far away.
std::vector<double> inputs() {
  std::vector<double> u = random_column(1, -1.5, 1.5);
  u[5] = 0.125;
  u[6] = 1e50;  // the farthest that inference looks
  u[7] = -1e50;
  u[8] = 0.125 + 1e-12;
  return u;
}

constexpr double kWidth = 0.3, kSlope = 2.3, kCentre = 0.125;

Columns bell_columns() {
  Columns c;
  bell_column(kRows, inputs().data(), kWidth, kSlope, kCentre, c.distance.data(), c.degree.data());
  return c;
}

Columns gaussian_columns() {
  Columns c;
  gaussian_column(kRows, inputs().data(), kWidth, kCentre, c.distance.data(), c.degree.data());
  return c;
}

TEST(Kernels, ColumnsAreTheScalarFunctionsBitForBit) {
  const std::vector<double> u = inputs();
  Columns bell, gaussian;
  for (std::size_t i = 0; i < kRows; ++i) {
    bell.distance[i] = inference::bell_distance(u[i], kWidth, kCentre);
    bell.degree[i] = inference::bell_degree(bell.distance[i], kSlope);
    gaussian.distance[i] = inference::gaussian_distance(u[i], kWidth, kCentre);
    gaussian.degree[i] = inference::gaussian_degree(gaussian.distance[i]);
    EXPECT_EQ(bell.degree[i], degree(anfis::bell(kWidth, kSlope, kCentre), u[i]));
    EXPECT_EQ(gaussian.degree[i], degree(anfis::gaussian(kWidth, kCentre), u[i]));
  }
  EXPECT_TRUE(same_bits(bell_columns().distance, bell.distance));
  EXPECT_TRUE(same_bits(bell_columns().degree, bell.degree));
  EXPECT_TRUE(same_bits(gaussian_columns().distance, gaussian.distance));
  EXPECT_TRUE(same_bits(gaussian_columns().degree, gaussian.degree));
}

// Sums in extended precision of the same terms; 136 additions of terms of at most `largest` leave an error below
// 136 * 1.1e-16 * 136 / 2 * largest in the worst case and 1e-14 * largest as a rule.
template <std::size_t n, class Terms>
void expect_sums(const std::array<double, n>& sums, const std::vector<double>& pull, Terms&& terms) {
  for (std::size_t p = 0; p < n; ++p) {
    long double sum = 0, size = 0;
    for (std::size_t i = 0; i < kRows; ++i) {
      const long double term = static_cast<long double>(pull[i]) * terms(i)[p];
      sum += term;
      size += std::abs(term);
    }
    EXPECT_GT(size, 1.0);
    EXPECT_NEAR(sums[p], static_cast<double>(sum), 1e-15 * static_cast<double>(size)) << p;
  }
}

TEST(Kernels, GradientsArePlainSums) {
  const std::vector<double> u = inputs();
  std::vector<double> pull = random_column(2, -1.0, 1.0);
  pull[6] = pull[7] = 0.0;  // as of padding rows
  const Columns bell = bell_columns(), gaussian = gaussian_columns();
  expect_sums(
      bell_gradient(kRows, u.data(), bell.distance.data(), bell.degree.data(), pull.data(), kWidth, kSlope, kCentre),
      pull, [&](std::size_t i) { return log_degree_derivatives(anfis::bell(kWidth, kSlope, kCentre), u[i]); });
  expect_sums(gaussian_gradient(kRows, u.data(), gaussian.distance.data(), pull.data(), kWidth, kCentre), pull,
              [&](std::size_t i) { return log_degree_derivatives(anfis::gaussian(kWidth, kCentre), u[i]); });
}

TEST(Kernels, DotIsThePlainSum) {
  const std::vector<double> a = random_column(3, -1.0, 1.0), b = random_column(4, -1.0, 1.0);
  long double sum = 0;
  for (std::size_t i = 0; i < kRows; ++i) sum += static_cast<long double>(a[i]) * b[i];
  EXPECT_NEAR(dot(kRows, a.data(), b.data()), static_cast<double>(sum), 1e-14);
  EXPECT_EQ(dot(0, a.data(), b.data()), 0.0);
}

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns) {
  base::Random random(5);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&](Eigen::Index, Eigen::Index) { return random.gaussian(); });
}

struct Factors {
  Eigen::MatrixXd q, r;
};

Factors factors(const Eigen::MatrixXd& a) {
  Factors f{a, Eigen::MatrixXd::Constant(a.cols(), a.cols(), 7.0)};
  triangular_factor(static_cast<std::size_t>(a.rows()), static_cast<std::size_t>(a.cols()), f.q.data(), f.r.data());
  return f;
}

// A random 136 x 12 matrix has a condition near 2: errors stay at some tens of roundings.
TEST(Kernels, TriangularFactorReproducesTheMatrix) {
  const Eigen::MatrixXd a = random_matrix(kRows, 12);
  const Factors f = factors(a);
  EXPECT_LT((f.r.transpose() * f.r - a.transpose() * a).norm(), 1e-14 * a.squaredNorm());
  EXPECT_LT((f.q * f.r - a).norm(), 1e-14 * a.norm());
  EXPECT_LT((f.q.transpose() * f.q - Eigen::MatrixXd::Identity(12, 12)).norm(), 1e-14);
  EXPECT_EQ(f.r.triangularView<Eigen::StrictlyLower>().toDenseMatrix().norm(), 0.0);
}

TEST(Kernels, TriangularFactorIsThatOfHouseholderUpToSigns) {
  const Eigen::MatrixXd a = random_matrix(kRows, 12);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  Eigen::MatrixXd r = qr.matrixQR().topRows(12).triangularView<Eigen::Upper>();
  for (Eigen::Index k = 0; k < 12; ++k) r.row(k) *= r(k, k) < 0.0 ? -1.0 : 1.0;
  EXPECT_LT((factors(a).r - r).norm(), 1e-13);
}

TEST(Kernels, TriangularFactorOfAZeroColumnIsZeroThere) {
  Eigen::MatrixXd a = random_matrix(kRows, 3);
  a.col(1).setZero();
  const Factors f = factors(a);
  EXPECT_TRUE(f.r.allFinite());
  EXPECT_EQ(f.r(1, 1), 0.0);
  EXPECT_EQ(f.r(1, 2), 0.0);
  EXPECT_LT((f.r.transpose() * f.r - a.transpose() * a).norm(), 1e-14 * a.squaredNorm());
}

// Singular values from 1 down to 1e-8.
Eigen::MatrixXd ill_conditioned(Eigen::Index columns) {
  const Eigen::MatrixXd u = Eigen::HouseholderQR<Eigen::MatrixXd>(random_matrix(kRows, columns)).householderQ() *
                            Eigen::MatrixXd::Identity(kRows, columns);
  const Eigen::MatrixXd v = Eigen::HouseholderQR<Eigen::MatrixXd>(random_matrix(columns, columns)).householderQ();
  const Eigen::ArrayXd exponent = Eigen::ArrayXd::LinSpaced(columns, 0.0, -8.0);
  return u * Eigen::pow(10.0, exponent).matrix().asDiagonal() * v.transpose();
}

// [Bjorck 1967] with b as the last column modified Gram-Schmidt is backward stable: the residual exceeds the least one
// by (backward error 1e-15 * |x|)^2 relative to it, for any condition.
TEST(Kernels, TriangularFactorSolvesIllConditionedLeastSquaresAsWellAsHouseholder) {
  constexpr Eigen::Index kColumns = 10;
  const Eigen::MatrixXd a = ill_conditioned(kColumns);
  base::Random random(6);
  Eigen::VectorXd b = a * Eigen::VectorXd::LinSpaced(kColumns, -1.0, 1.0);
  for (double& value : b) value += 1e-6 * random.gaussian();
  Eigen::MatrixXd both(kRows, kColumns + 1);
  both << a, b;
  const Factors f = factors(both);
  const Eigen::VectorXd x =
      f.r.topLeftCorner(kColumns, kColumns).triangularView<Eigen::Upper>().solve(f.r.col(kColumns).head(kColumns));
  const Eigen::VectorXd reference = a.householderQr().solve(b);
  const double least = (a * reference - b).norm();
  EXPECT_GT(least, 1e-6);
  EXPECT_NEAR((a * x - b).norm() / least, 1.0, 1e-9);
  EXPECT_NEAR(f.r(kColumns, kColumns) / least, 1.0, 1e-9);  // the last diagonal element is the residual's norm
  // Solutions differ by condition^2 * residual * 1e-16 = 1e-5 at most.
  EXPECT_LT((x - reference).norm(), 1e-5);
}

// The loader picks the clone for this processor; the copy in kernels_baseline.cpp is compiled for any x86-64 one.
TEST(Kernels, GiveTheSameBitsOnEveryInstructionSet) {
  const std::vector<double> u = inputs(), pull = random_column(2, -1.0, 1.0);
  const Columns bell = bell_columns(), gaussian = gaussian_columns();
  Columns plain;
  baseline::bell_column(kRows, u.data(), kWidth, kSlope, kCentre, plain.distance.data(), plain.degree.data());
  EXPECT_TRUE(same_bits(plain.distance, bell.distance));
  EXPECT_TRUE(same_bits(plain.degree, bell.degree));
  EXPECT_EQ(
      baseline::bell_gradient(kRows, u.data(), bell.distance.data(), bell.degree.data(), pull.data(), kWidth, kSlope,
                              kCentre),
      bell_gradient(kRows, u.data(), bell.distance.data(), bell.degree.data(), pull.data(), kWidth, kSlope, kCentre));
  baseline::gaussian_column(kRows, u.data(), kWidth, kCentre, plain.distance.data(), plain.degree.data());
  EXPECT_TRUE(same_bits(plain.distance, gaussian.distance));
  EXPECT_TRUE(same_bits(plain.degree, gaussian.degree));
  EXPECT_EQ(baseline::gaussian_gradient(kRows, u.data(), gaussian.distance.data(), pull.data(), kWidth, kCentre),
            gaussian_gradient(kRows, u.data(), gaussian.distance.data(), pull.data(), kWidth, kCentre));
  EXPECT_EQ(baseline::dot(kRows, u.data(), pull.data()), dot(kRows, u.data(), pull.data()));
}

TEST(Kernels, TriangularFactorGivesTheSameBitsOnEveryInstructionSet) {
  const Eigen::MatrixXd a = ill_conditioned(13);
  const Factors f = factors(a);
  Factors plain{a, f.r};
  plain.r.setConstant(7.0);
  baseline::triangular_factor(kRows, 13, plain.q.data(), plain.r.data());
  EXPECT_EQ(plain.r, f.r);
  EXPECT_EQ(plain.q, f.q);
}

}  // namespace
}  // namespace soak::anfis::training
