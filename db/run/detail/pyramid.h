// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "db/detail/column_codec.h"
#include "db/detail/sqlite.h"
#include "db/run/detail/tables.h"
#include "db/run/run_file.h"

/// The multi-resolution pyramid of a run file's channels.
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

/// Gathers rows or smaller bins into one bin. Values that are not finite count as absent.
class BinSum {
 public:
  void add(double t_s, double value);
  void add(const PyramidBin& part);
  /// Rows or bins added since the last take().
  [[nodiscard]] std::uint64_t parts() const { return parts_; }
  /// The bin; starts the next one.
  PyramidBin take();

 private:
  void cover(double t_first_s, double t_last_s);

  std::uint64_t parts_ = 0;
  PyramidBin bin_;
  long double sum_ = 0.0L;  // wider exponent than double: a sum of large numbers does not overflow
};

struct LevelBin {
  unsigned level = 0;
  std::uint64_t index = 0;  ///< covers rows from index · rows_per_bin(level)
  PyramidBin bin;
};

/// Builds all levels of one channel's pyramid in one pass over its rows, in constant memory.
class PyramidBuilder {
 public:
  /// Takes the next rows; appends the bins that they complete to `done`.
  void add(std::span<const double> t_s, std::span<const double> values, std::vector<LevelBin>& done);
  /// Ends the last, incomplete bins; the topmost level then has one bin.
  void finish(std::vector<LevelBin>& done);

 private:
  void end_bin(unsigned level, std::vector<LevelBin>& done);

  std::array<BinSum, kPyramidLevels> sums_;
  std::array<std::uint64_t, kPyramidLevels> ended_{};
};

/// Stores the bins that hold a value. Throws SQLite::Exception.
void insert_bins(SQLite::Database& database, std::int64_t channel_id, const std::vector<LevelBin>& bins);

/// Bins of one level from `first` to `last`, in order. Throws SQLite::Exception.
[[nodiscard]] std::vector<LevelBin> read_bins(const SQLite::Database& database, std::int64_t channel_id, unsigned level,
                                              std::uint64_t first, std::uint64_t last);

/// What a question to the pyramid is about.
struct PyramidSpan {
  double from_s = 0.0;
  double to_s = 0.0;
  std::size_t max_bins = 1;
};

/// See RunFileReader::pyramid(). `finished`: all levels cover all rows; otherwise each level covers what its complete
/// bins do, and smaller bins or samples stand in for the rest.
[[nodiscard]] base::Result<std::vector<PyramidBin>> query_pyramid(const sqlite::Connection& connection,
                                                                  codec::ColumnDecoder& decoder,
                                                                  const StoredStream& stream, std::size_t channel,
                                                                  bool finished, const PyramidSpan& span);

/// See RunFileReader::rows_between().
[[nodiscard]] base::Result<RowSpan> query_rows(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                               const StoredStream& stream, bool finished, const PyramidSpan& span);

}  // namespace soak::db::run
