// SPDX-License-Identifier: Apache-2.0
#include "db/run/detail/pyramid.h"

#include <SQLiteCpp/Statement.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "db/detail/fields.h"

namespace soak::db::run {

void BinSum::cover(double t_first_s, double t_last_s) {
  if (parts_++ == 0) bin_.t_first_s = t_first_s;
  bin_.t_last_s = t_last_s;
}

void BinSum::add(double t_s, double value) {
  cover(t_s, t_s);
  if (!std::isfinite(value)) return;
  bin_.minimum = bin_.count == 0 ? value : std::min(bin_.minimum, value);
  bin_.maximum = bin_.count == 0 ? value : std::max(bin_.maximum, value);
  ++bin_.count;
  sum_ += static_cast<long double>(value);
}

void BinSum::add(const PyramidBin& part) {
  cover(part.t_first_s, part.t_last_s);
  if (part.count == 0) return;
  bin_.minimum = bin_.count == 0 ? part.minimum : std::min(bin_.minimum, part.minimum);
  bin_.maximum = bin_.count == 0 ? part.maximum : std::max(bin_.maximum, part.maximum);
  bin_.count += part.count;
  sum_ += static_cast<long double>(part.count) * static_cast<long double>(part.mean);
}

PyramidBin BinSum::take() {
  PyramidBin bin = bin_;
  // Rounding must not push the mean of equal numbers past them.
  if (bin.count > 0) {
    const auto mean = static_cast<double>(sum_ / static_cast<long double>(bin.count));
    bin.mean = std::clamp(mean, bin.minimum, bin.maximum);
  }
  *this = BinSum();
  return bin;
}

void PyramidBuilder::end_bin(unsigned level, std::vector<LevelBin>& done) {
  const LevelBin ended{level, ended_[level]++, sums_[level].take()};
  done.push_back(ended);
  if (level + 1 == kPyramidLevels) return;
  sums_[level + 1].add(ended.bin);
  if (sums_[level + 1].parts() == kPyramidFactor) end_bin(level + 1, done);
}

void PyramidBuilder::add(std::span<const double> t_s, std::span<const double> values, std::vector<LevelBin>& done) {
  for (std::size_t row = 0; row < values.size(); ++row) {
    sums_[0].add(t_s[row], values[row]);
    if (sums_[0].parts() == kBaseBinRows) end_bin(0, done);
  }
}

void PyramidBuilder::finish(std::vector<LevelBin>& done) {
  for (unsigned level = 0; level < kPyramidLevels; ++level) {
    if (level > 0 && ended_[level - 1] <= 1) return;
    if (sums_[level].parts() > 0) end_bin(level, done);
  }
}

void insert_bins(SQLite::Database& database, std::int64_t channel_id, const std::vector<LevelBin>& bins) {
  SQLite::Statement insert(database, "INSERT INTO pyramid VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const LevelBin& level_bin : bins) {
    const PyramidBin& bin = level_bin.bin;
    if (bin.count == 0) continue;
    sqlite::bind_all(insert, channel_id, level_bin.level, level_bin.index, bin.t_first_s, bin.t_last_s, bin.count,
                     bin.minimum, bin.mean, bin.maximum);
    insert.exec();
    insert.reset();
  }
}

std::vector<LevelBin> read_bins(const SQLite::Database& database, std::int64_t channel_id, unsigned level,
                                std::uint64_t first, std::uint64_t last) {
  SQLite::Statement query(database,
                          "SELECT bin, t_first_s, t_last_s, count, minimum, mean, maximum FROM pyramid "
                          "WHERE channel_id = ? AND level = ? AND bin BETWEEN ? AND ? ORDER BY bin");
  sqlite::bind_all(query, channel_id, level, first, last);
  std::vector<LevelBin> bins;
  while (query.executeStep()) {
    sqlite::Fields fields(query);
    LevelBin& level_bin = bins.emplace_back();
    level_bin.level = level;
    level_bin.index = static_cast<std::uint64_t>(fields.integer());
    PyramidBin& bin = level_bin.bin;
    bin.t_first_s = fields.real();
    bin.t_last_s = fields.real();
    bin.count = static_cast<std::uint64_t>(fields.integer());
    bin.minimum = fields.real();
    bin.mean = fields.real();
    bin.maximum = fields.real();
  }
  return bins;
}

}  // namespace soak::db::run
