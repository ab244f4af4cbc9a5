// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/result.h"
#include "db/detail/connection.h"
#include "db/run/detail/layout.h"
#include "db/run/run_file.h"

namespace soak::db::run {

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

}  // namespace soak::db::run
