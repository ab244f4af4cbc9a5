// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/differences.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calib/signal/allan/detail/kernels.h"

namespace soak::calib::signal::allan {
namespace {

bool overlaps(AllanKind kind) { return kind != AllanKind::plain && kind != AllanKind::hadamard; }

/// The differences without overlap are those of every m-th point at multiple 1.
double sum_without_overlap(AllanKind kind, const double* x, std::size_t m, std::size_t starts) {
  const std::size_t reach = kind == AllanKind::plain ? 2 : 3;
  std::array<double, kBlock + 3> thinned;
  for (std::size_t i = 0; i < starts + reach; ++i) thinned[i] = x[i * m];
  return reach == 2 ? second_differences(thinned.data(), 1, starts) : third_differences(thinned.data(), 1, starts);
}

double sum_of_squares(AllanKind kind, const double* x, std::size_t m, std::size_t starts) {
  switch (kind) {
    case AllanKind::overlapping:
      return second_differences(x, m, starts);
    case AllanKind::overlapping_hadamard:
      return third_differences(x, m, starts);
    case AllanKind::modified:
      return modified_differences(x, m, starts);
    default:
      return sum_without_overlap(kind, x, m, starts);
  }
}

/// Blocks that share the cache: 256 KB, and runs long enough for the processor to read ahead in.
constexpr std::size_t kTile = 8 * kBlock;

/// Adds the differences that begin in the first `count` points, a whole number of blocks; none where multiple m does
/// not share them.
void add_beginnings(AllanKind kind, std::span<const double> points, std::size_t count, std::size_t m, SquareSum& sum) {
  if (!shares_blocks(kind, m)) return;
  const std::size_t terms = std::min(count, terms_of(kind, points.size(), m));
  for (std::size_t i = 0; i < terms; i += kBlock) {
    sum.sum += sum_of_squares(kind, points.data() + i, m, std::min(kBlock, terms - i));
  }
  sum.terms += terms;
}

}  // namespace

std::size_t longest_of(AllanKind kind, std::size_t points) {
  if (points == 0) return 0;
  switch (kind) {
    case AllanKind::plain:
    case AllanKind::overlapping:
      return (points - 1) / 2;
    case AllanKind::modified:
      return points / 3;
    default:
      return (points - 1) / 3;
  }
}

std::size_t terms_of(AllanKind kind, std::size_t points, std::size_t m) {
  if (m == 0 || m > longest_of(kind, points)) return 0;
  switch (kind) {
    case AllanKind::plain:
      return (points - 1) / m - 1;
    case AllanKind::hadamard:
      return (points - 1) / m - 2;
    case AllanKind::overlapping:
      return points - 2 * m;
    case AllanKind::overlapping_hadamard:
      return points - 3 * m;
    default:
      return points - 3 * m + 1;
  }
}

bool shares_blocks(AllanKind kind, std::size_t m) {
  return overlaps(kind) && (kind != AllanKind::modified || m <= kBlock);
}

void add_block(AllanKind kind, std::span<const double> points, std::span<const std::size_t> multiples,
               std::span<SquareSum> sums) {
  for (std::size_t k = 0; k < multiples.size(); ++k) add_beginnings(kind, points, kBlock, multiples[k], sums[k]);
}

void add_blocks(AllanKind kind, std::span<const double> points, std::span<const std::size_t> multiples,
                std::span<SquareSum> sums) {
  for (; !points.empty(); points = points.subspan(std::min(kTile, points.size()))) {
    for (std::size_t k = 0; k < multiples.size(); ++k) add_beginnings(kind, points, kTile, multiples[k], sums[k]);
  }
}

void add_stretch(AllanKind kind, std::span<const double> points, std::size_t m, SquareSum& sum) {
  const std::size_t terms = terms_of(kind, points.size(), m);
  const std::size_t block = kind == AllanKind::modified ? std::max(kBlock, m) : kBlock;
  const std::size_t stride = overlaps(kind) ? 1 : m;
  for (std::size_t i = 0; i < terms; i += block) {
    sum.sum += sum_of_squares(kind, points.data() + i * stride, m, std::min(block, terms - i));
  }
  sum.terms += terms;
}

double deviation_of(AllanKind kind, const SquareSum& squares, std::size_t m, std::size_t window) {
  if (squares.terms == 0) return std::numeric_limits<double>::quiet_NaN();
  const bool hadamard = kind == AllanKind::hadamard || kind == AllanKind::overlapping_hadamard;
  const double length = static_cast<double>(m) * (kind == AllanKind::modified ? static_cast<double>(window) : 1.0);
  return std::sqrt(squares.sum / static_cast<double>(squares.terms) / (hadamard ? 6.0 : 2.0)) / length;
}

}  // namespace soak::calib::signal::allan
