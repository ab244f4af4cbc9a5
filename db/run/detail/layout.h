// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

/// Numbers of the run file's format that writer and reader share.
namespace soak::db::run {

/// Rows of a full chunk. A flush in between writes short chunks, which the full one then replaces: every number is
/// written twice at most, however often a recorder flushes.
inline constexpr std::size_t kChunkRows = 16384;

/// Rows of a bin of the pyramid's level 0, and how many bins of a level make one of the next.
inline constexpr std::uint64_t kBaseBinRows = 512;
inline constexpr std::uint64_t kPyramidFactor = 8;
inline constexpr unsigned kPyramidLevels = 12;

static_assert(kChunkRows % kBaseBinRows == 0, "a full chunk ends at the end of a bin");

/// Rows that a bin of `level` covers.
constexpr std::uint64_t rows_per_bin(unsigned level) {
  std::uint64_t rows = kBaseBinRows;
  for (unsigned i = 0; i < level; ++i) rows *= kPyramidFactor;
  return rows;
}

}  // namespace soak::db::run
