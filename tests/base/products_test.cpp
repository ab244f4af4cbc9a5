// SPDX-License-Identifier: Apache-2.0
// Products of matrices: right at every size at which blocks are full or not, and the same on every processor.
#include "base/linear/products.h"

#include <gtest/gtest.h>

#include <array>

// A second copy without clones for newer processors, under another name.
#include <algorithm>
#include <cstring>

#include "base/instruction_set.h"
#undef SOAK_CLONES
#define SOAK_CLONES
#define base base_baseline
namespace soak::base_baseline {
using ConstMatrix = Eigen::Ref<const Eigen::MatrixXd>;
}
#include "base/linear/products.cpp"  // NOLINT(bugprone-suspicious-include): the point of this test
#undef base

namespace soak::base {
namespace {

using Eigen::MatrixXd;

struct Sizes {
  Eigen::Index rows;
  Eigen::Index inner;
  Eigen::Index columns;
};
// Blocks are of four rows and two columns, or of eight rows and four columns.
constexpr std::array<Sizes, 9> kSizes = {
    {{1, 1, 1}, {8, 4, 4}, {7, 3, 2}, {9, 5, 3}, {103, 13, 6}, {64, 33, 17}, {31, 2, 1}, {0, 3, 2}, {5, 0, 3}}};

/// Sums of so few products of numbers up to 1 differ by rounding alone.
constexpr double kRounding = 1e-13;

/// Whether the products run the clones for newer processors: they are compiled in (base/instruction_set.h) and this
/// processor has AVX2.
bool runs_clones() {
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__)
  return __builtin_cpu_supports("x86-64-v3") != 0;
#else
  return false;
#endif
}

double largest(const MatrixXd& m) { return m.size() > 0 ? m.cwiseAbs().maxCoeff() : 0.0; }

TEST(Products, AreThoseOfEigen) {
  for (const auto& [rows, inner, columns] : kSizes) {
    const MatrixXd a = MatrixXd::Random(rows, inner);
    const MatrixXd b = MatrixXd::Random(rows, columns);
    const MatrixXd c = MatrixXd::Random(inner, columns);
    EXPECT_LT(largest(transposed_product(a, b) - a.transpose() * b), kRounding) << rows << " " << inner;
    EXPECT_LT(largest(product(a, c) - a * c), kRounding) << rows << " " << inner;
    MatrixXd left = b;
    subtract_product(a, c, left);
    EXPECT_LT(largest(left - (b - a * c)), kRounding) << rows << " " << inner;
    const MatrixXd off = lower_products(a) - a.transpose() * a;
    EXPECT_LT(largest(off.triangularView<Eigen::Lower>()), kRounding) << rows << " " << inner;
  }
}

TEST(Products, TakePartsOfLargerMatrices) {
  const MatrixXd a = MatrixXd::Random(40, 12);
  const MatrixXd b = MatrixXd::Random(40, 6);
  EXPECT_EQ(transposed_product(a.middleRows(5, 21), b.middleRows(5, 21)),
            transposed_product(MatrixXd(a.middleRows(5, 21)), MatrixXd(b.middleRows(5, 21))));
  EXPECT_EQ(product(a.middleRows(5, 21), b.topRows(12)), MatrixXd(product(a, b.topRows(12)).middleRows(5, 21)).eval());
}

TEST(Products, AreTheSameWithoutClonesForNewerProcessors) {
  if (!runs_clones()) GTEST_SKIP() << "both copies would be the same: no AVX2, or no clones in this build";
  for (const auto& [rows, inner, columns] : kSizes) {
    const MatrixXd a = MatrixXd::Random(rows, inner);
    const MatrixXd b = MatrixXd::Random(rows, columns);
    const MatrixXd c = MatrixXd::Random(inner, columns);
    EXPECT_EQ(transposed_product(a, b), base_baseline::transposed_product(a, b));
    EXPECT_EQ(product(a, c), base_baseline::product(a, c));
    EXPECT_EQ(lower_products(a), base_baseline::lower_products(a));
    MatrixXd left = b;
    MatrixXd also_left = b;
    subtract_product(a, c, left);
    base_baseline::subtract_product(a, c, also_left);
    EXPECT_EQ(left, also_left);
  }
}

}  // namespace
}  // namespace soak::base
