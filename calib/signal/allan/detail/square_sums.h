// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "calib/signal/allan/allan.h"

namespace soak::calib::signal::allan {

/// Differences are added up in blocks of so many beginnings, counted from the first point of the stretch, whatever
/// other multiples are asked for and however the record comes in: that fixes the bits of every sum.
inline constexpr std::size_t kBlock = 4096;

/// Squared differences of one kind at one multiple.
struct SquareSum {
  double sum = 0.0;
  std::size_t terms = 0;
};

/// Largest multiple at which so many phase points without a gap give a difference; 0: none.
[[nodiscard]] std::size_t longest_of(AllanKind kind, std::size_t points);

/// Differences that so many phase points without a gap give at multiple m; 0 for m = 0.
[[nodiscard]] std::size_t terms_of(AllanKind kind, std::size_t points, std::size_t m);

/// Whether add_blocks() takes this multiple: the overlapping kinds, modified Allan only up to kBlock (beyond, windows
/// are longer than blocks).
[[nodiscard]] bool shares_blocks(AllanKind kind, std::size_t m);

/// Adds the differences that begin in the first block of `points`, at each multiple that shares_blocks(); the sums of
/// others stay as they are.
void add_block(AllanKind kind, std::span<const double> points, std::span<const std::size_t> multiples,
               std::span<SquareSum> sums);

/// Adds the differences of a stretch, or of its rest from the beginning of a block on, block by block: the multiples
/// share what some blocks have brought into the cache.
void add_blocks(AllanKind kind, std::span<const double> points, std::span<const std::size_t> multiples,
                std::span<SquareSum> sums);

/// Adds the differences of a stretch at one multiple of any kind. Where add_blocks() would do, the same bits.
void add_stretch(AllanKind kind, std::span<const double> points, std::size_t m, SquareSum& sum);

/// The deviation at multiple m [NIST SP 1065 eq. 7-19], from phase in units of the sample interval:
///   Allan sqrt(mean d^2 / 2m^2), Hadamard sqrt(mean d^2 / 6m^2), modified Allan sqrt(mean S^2 / 2m^2 w^2),
/// w the points of the window S (m, or fewer where the points are means over m/w). NaN where there is no term.
[[nodiscard]] double deviation_of(AllanKind kind, const SquareSum& squares, std::size_t m, std::size_t window);

}  // namespace soak::calib::signal::allan
