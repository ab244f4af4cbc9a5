// SPDX-License-Identifier: Apache-2.0
#include "base/linear/products.h"

#include <algorithm>
#include <cstring>

#include "base/instruction_set.h"

namespace soak::base {
namespace {

/// Four numbers in one register, or in two where the processor has no wider ones.
using Four [[gnu::vector_size(4 * sizeof(double))]] = double;
using Index = Eigen::Index;

SOAK_INLINE void load(const double* from, Four& to) { std::memcpy(&to, from, sizeof to); }

/// A matrix by columns: entry (i, k) lies at data[i + k * stride].
struct View {
  const double* data;
  Index rows;
  Index columns;
  Index stride;

  explicit View(const ConstMatrix& m) : data(m.data()), rows(m.rows()), columns(m.cols()), stride(m.outerStride()) {}
  /// Of a column beyond the last one: the last one, so that a block is always full.
  [[nodiscard]] const double* column(Index k) const { return data + std::min(k, columns - 1) * stride; }
};

/// Σ_i a(i) b(i) of four columns of a with two of b: rows in four sums, which are added at the end, then the last rows.
SOAK_INLINE void add_up(const View& a, Index first, const View& b, Index second, double* sums) {
  const double* const a0 = a.column(first);
  const double* const a1 = a.column(first + 1);
  const double* const a2 = a.column(first + 2);
  const double* const a3 = a.column(first + 3);
  const double* const b0 = b.column(second);
  const double* const b1 = b.column(second + 1);
  Four s00{}, s10{}, s20{}, s30{}, s01{}, s11{}, s21{}, s31{}, x0, x1, x, y;
  Index i = 0;
  for (; i + 4 <= a.rows; i += 4) {
    load(b0 + i, x0);
    load(b1 + i, x1);
    load(a0 + i, x);
    load(a1 + i, y);
    s00 += x * x0;
    s01 += x * x1;
    s10 += y * x0;
    s11 += y * x1;
    load(a2 + i, x);
    load(a3 + i, y);
    s20 += x * x0;
    s21 += x * x1;
    s30 += y * x0;
    s31 += y * x1;
  }
  const auto sum = [&](const Four& s, const double* left, const double* right) {
    double total = (s[0] + s[1]) + (s[2] + s[3]);
    for (Index row = i; row < a.rows; ++row) total += left[row] * right[row];
    return total;
  };
  sums[0] = sum(s00, a0, b0);
  sums[1] = sum(s10, a1, b0);
  sums[2] = sum(s20, a2, b0);
  sums[3] = sum(s30, a3, b0);
  sums[4] = sum(s01, a0, b1);
  sums[5] = sum(s11, a1, b1);
  sums[6] = sum(s21, a2, b1);
  sums[7] = sum(s31, a3, b1);
}

/// result(i, k) = Σ a(·, i) b(·, k), block by block; `lower`: only those that reach to the diagonal.
SOAK_CLONES void multiply_transposed(const View& a, const View& b, bool lower, double* result) {
  double sums[8] = {};
  for (Index k = 0; k < b.columns; k += 2) {
    for (Index i = lower ? k / 4 * 4 : 0; i < a.columns; i += 4) {
      add_up(a, i, b, k, sums);
      for (Index column = k; column < std::min(k + 2, b.columns); ++column) {
        const Index count = std::min<Index>(4, a.columns - i);
        std::copy_n(sums + 4 * (column - k), count, result + column * a.columns + i);
      }
    }
  }
}

/// Eight rows of a b in four columns, term by term; they are written, or taken off what is there.
SOAK_INLINE void eight_rows(const View& a, const View& b, Index row, Index first, bool subtract, double* result) {
  const double* const b0 = b.column(first);
  const double* const b1 = b.column(first + 1);
  const double* const b2 = b.column(first + 2);
  const double* const b3 = b.column(first + 3);
  Four s0{}, s1{}, s2{}, s3{}, t0{}, t1{}, t2{}, t3{}, x, y;
  for (Index k = 0; k < a.columns; ++k) {
    load(a.data + row + k * a.stride, x);
    load(a.data + row + 4 + k * a.stride, y);
    s0 += x * b0[k];
    t0 += y * b0[k];
    s1 += x * b1[k];
    t1 += y * b1[k];
    s2 += x * b2[k];
    t2 += y * b2[k];
    s3 += x * b3[k];
    t3 += y * b3[k];
  }
  const auto store = [&](const Four& upper, const Four& lower, Index column) {
    if (column >= b.columns) return;
    double* const to = result + column * a.rows + row;
    for (int i = 0; i < 4; ++i) {
      to[i] = subtract ? to[i] - upper[i] : upper[i];
      to[i + 4] = subtract ? to[i + 4] - lower[i] : lower[i];
    }
  };
  store(s0, t0, first);
  store(s1, t1, first + 1);
  store(s2, t2, first + 2);
  store(s3, t3, first + 3);
}

SOAK_CLONES void multiply(const View& a, const View& b, bool subtract, double* result) {
  Index row = 0;
  for (; row + 8 <= a.rows; row += 8) {
    for (Index first = 0; first < b.columns; first += 4) eight_rows(a, b, row, first, subtract, result);
  }
  for (; row < a.rows; ++row) {
    for (Index column = 0; column < b.columns; ++column) {
      double sum = 0.0;
      for (Index k = 0; k < a.columns; ++k) sum += a.data[row + k * a.stride] * b.column(column)[k];
      double& to = result[column * a.rows + row];
      to = subtract ? to - sum : sum;
    }
  }
}

}  // namespace

Eigen::MatrixXd transposed_product(const ConstMatrix& a, const ConstMatrix& b) {
  eigen_assert(a.rows() == b.rows());
  if (b.cols() == 1) return a.transpose() * b;  // blocks would be half empty
  Eigen::MatrixXd result(a.cols(), b.cols());
  if (result.size() > 0) multiply_transposed(View(a), View(b), false, result.data());
  return result;
}

Eigen::MatrixXd lower_products(const ConstMatrix& a) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(a.cols(), a.cols());
  if (result.size() > 0) multiply_transposed(View(a), View(a), true, result.data());
  return result;
}

Eigen::MatrixXd product(const ConstMatrix& a, const ConstMatrix& b) {
  eigen_assert(a.cols() == b.rows());
  if (b.cols() == 1) return a * b;
  Eigen::MatrixXd result(a.rows(), b.cols());
  if (result.size() > 0) multiply(View(a), View(b), false, result.data());
  return result;
}

void subtract_product(const ConstMatrix& a, const ConstMatrix& b, Eigen::MatrixXd& c) {
  eigen_assert(a.cols() == b.rows() && c.rows() == a.rows() && c.cols() == b.cols());
  if (b.cols() == 1) {
    c.noalias() -= a * b;
  } else if (c.size() > 0) {
    multiply(View(a), View(b), true, c.data());
  }
}

}  // namespace soak::base
