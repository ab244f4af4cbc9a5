// SPDX-License-Identifier: Apache-2.0
#include "db/run/detail/pyramid.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

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

namespace {

struct RowRange {
  std::uint64_t first = 0;
  std::uint64_t end = 0;
};

/// Joins parts whose first rows lie in the same group of rows.
class Joiner {
 public:
  explicit Joiner(std::uint64_t rows_per_group) : rows_per_group_(rows_per_group) {}

  template <class Add>
  void add(std::uint64_t first_row, const Add& add_to) {
    const std::uint64_t group = first_row / rows_per_group_;
    if (group != group_) end_group();
    group_ = group;
    add_to(sum_);
  }
  std::vector<PyramidBin> take() {
    end_group();
    return std::move(bins_);
  }

 private:
  void end_group() {
    const PyramidBin bin = sum_.take();
    if (bin.count > 0) bins_.push_back(bin);
  }

  std::uint64_t rows_per_group_;
  std::uint64_t group_ = 0;
  BinSum sum_;
  std::vector<PyramidBin> bins_;
};

/// Base bins of a time axis, which are asked for one by one.
class TimeBins {
 public:
  struct Times {
    double first_s = 0.0;
    double last_s = 0.0;
  };

  TimeBins(const SQLite::Database& database, std::int64_t channel_id)
      : query_(database, "SELECT t_first_s, t_last_s FROM pyramid WHERE channel_id = ? AND level = 0 AND bin = ?"),
        channel_id_(channel_id) {}

  [[nodiscard]] std::optional<Times> at(std::uint64_t index) {
    query_.reset();
    sqlite::bind_all(query_, channel_id_, index);
    if (!query_.executeStep()) return std::nullopt;
    sqlite::Fields fields(query_);
    const double first_s = fields.real();
    return Times{first_s, fields.real()};
  }

 private:
  SQLite::Statement query_;
  std::int64_t channel_id_;
};

class PyramidQuery {
 public:
  PyramidQuery(const sqlite::Connection& connection, codec::ColumnDecoder& decoder, const StoredStream& stream,
               std::size_t channel, bool finished)
      : connection_(connection),
        decoder_(decoder),
        stream_(stream),
        time_(stream.channels.front()),
        channel_(stream.channels[channel]),
        finished_(finished) {}

  [[nodiscard]] base::Result<std::vector<PyramidBin>> answer(const PyramidSpan& span);
  [[nodiscard]] base::Result<RowSpan> rows(const PyramidSpan& span);

 private:
  [[nodiscard]] std::uint64_t count_base_bins() const;
  [[nodiscard]] base::Result<RowRange> rows_of(const PyramidSpan& span) const;
  [[nodiscard]] std::uint64_t rows_covered(unsigned level) const;
  [[nodiscard]] base::Result<std::vector<double>> times(RowRange rows);
  [[nodiscard]] base::Status add_samples(Joiner& joiner, RowRange rows, const PyramidSpan& span);
  [[nodiscard]] base::Result<std::vector<PyramidBin>> from_samples(RowRange rows, const PyramidSpan& span);
  [[nodiscard]] base::Result<std::vector<PyramidBin>> from_levels(RowRange rows, const PyramidSpan& span);

  const sqlite::Connection& connection_;
  codec::ColumnDecoder& decoder_;
  const StoredStream& stream_;
  const StoredChannel& time_;
  const StoredChannel& channel_;
  bool finished_;
  std::uint64_t base_bins_ = 0;  ///< of the time axis, which has a value in every row
};

std::uint64_t PyramidQuery::count_base_bins() const {
  SQLite::Statement query(connection_.database(),
                          "SELECT coalesce(max(bin) + 1, 0) FROM pyramid WHERE channel_id = ? AND level = 0");
  sqlite::bind_all(query, time_.id);
  query.executeStep();
  const std::uint64_t possible = (stream_.rows + kBaseBinRows - 1) / kBaseBinRows;
  return std::min(possible, static_cast<std::uint64_t>(query.getColumn(0).getInt64()));
}

std::uint64_t PyramidQuery::rows_covered(unsigned level) const {
  const std::uint64_t rows = std::min(stream_.rows, base_bins_ * kBaseBinRows);
  return finished_ ? rows : rows / rows_per_bin(level) * rows_per_bin(level);
}

/// Rows of the span to the precision of a base bin; rows that the pyramid does not cover belong to it.
base::Result<RowRange> PyramidQuery::rows_of(const PyramidSpan& span) const {
  TimeBins bins(connection_.database(), time_.id);
  // Number of bins, counted from the first, for which `before` holds; the bins are in the order of time.
  const auto count_while = [&](const auto& before) -> base::Result<std::uint64_t> {
    std::uint64_t low = 0;
    std::uint64_t high = base_bins_;
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      const auto bin = bins.at(middle);
      if (!bin) return base::corrupt("a bin of the pyramid is missing", connection_.path().string());
      (before(*bin) ? low : high) = before(*bin) ? middle + 1 : middle;
    }
    return low;
  };
  const auto first = count_while([&](const TimeBins::Times& bin) { return bin.last_s < span.from_s; });
  if (!first) return base::forward_error(first);
  const auto end = count_while([&](const TimeBins::Times& bin) { return bin.first_s <= span.to_s; });
  if (!end) return base::forward_error(end);
  const std::uint64_t end_row = *end == base_bins_ ? stream_.rows : *end * kBaseBinRows;
  return RowRange{std::min(*first * kBaseBinRows, end_row), std::min(end_row, stream_.rows)};
}

base::Result<std::vector<double>> PyramidQuery::times(RowRange rows) {
  const auto column = read_rows(connection_, decoder_, time_, rows.first, rows.end - rows.first);
  if (!column) return base::forward_error(column);
  return values_of(*column, time_.info.scale, time_.info.offset);
}

/// The span begins in the first base bin of rows_of() and ends in the last one, or in the rows that have no bin yet.
base::Result<RowSpan> PyramidQuery::rows(const PyramidSpan& span) {
  base_bins_ = count_base_bins();
  const auto rough = rows_of(span);
  if (!rough) return base::forward_error(rough);
  if (rough->first == rough->end) return RowSpan{rough->first, 0};
  const std::uint64_t binned = std::min(stream_.rows, base_bins_ * kBaseBinRows);
  const RowRange head{rough->first,
                      rough->first < binned ? std::min(rough->end, rough->first + kBaseBinRows) : rough->end};
  const auto early = times(head);
  if (!early) return base::forward_error(early);
  const auto before = std::lower_bound(early->begin(), early->end(), span.from_s) - early->begin();
  const std::uint64_t last_bin = (std::min(rough->end, binned) - 1) / kBaseBinRows * kBaseBinRows;
  const RowRange tail{std::max(rough->first, binned == 0 ? 0 : last_bin), rough->end};
  const auto late = times(tail);
  if (!late) return base::forward_error(late);
  const auto until = std::upper_bound(late->begin(), late->end(), span.to_s) - late->begin();
  const std::uint64_t first = head.first + static_cast<std::uint64_t>(before);
  const std::uint64_t end = tail.first + static_cast<std::uint64_t>(until);
  return RowSpan{first, end > first ? end - first : 0};
}

/// Adds the samples of `rows` that lie in the span.
base::Status PyramidQuery::add_samples(Joiner& joiner, RowRange rows, const PyramidSpan& span) {
  if (rows.first >= rows.end) return {};
  const auto times = read_rows(connection_, decoder_, time_, rows.first, rows.end - rows.first);
  if (!times) return base::forward_error(times);
  const auto numbers = read_rows(connection_, decoder_, channel_, rows.first, rows.end - rows.first);
  if (!numbers) return base::forward_error(numbers);
  const auto t_s = values_of(*times, time_.info.scale, time_.info.offset);
  const auto values = values_of(*numbers, channel_.info.scale, channel_.info.offset);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (t_s[i] < span.from_s || t_s[i] > span.to_s) continue;
    joiner.add(rows.first + i, [&](BinSum& sum) { sum.add(t_s[i], values[i]); });
  }
  return {};
}

base::Result<std::vector<PyramidBin>> PyramidQuery::from_samples(RowRange rows, const PyramidSpan& span) {
  const auto times = read_rows(connection_, decoder_, time_, rows.first, rows.end - rows.first);
  if (!times) return base::forward_error(times);
  const auto t_s = values_of(*times, time_.info.scale, time_.info.offset);
  const auto first = std::lower_bound(t_s.begin(), t_s.end(), span.from_s);
  const auto end = std::upper_bound(first, t_s.end(), span.to_s);
  const RowRange inside{rows.first + static_cast<std::uint64_t>(first - t_s.begin()),
                        rows.first + static_cast<std::uint64_t>(end - t_s.begin())};
  Joiner joiner(std::max<std::uint64_t>(1, (inside.end - inside.first + span.max_bins - 1) / span.max_bins));
  if (const auto added = add_samples(joiner, inside, span); !added) return base::forward_error(added);
  return joiner.take();
}

base::Result<std::vector<PyramidBin>> PyramidQuery::from_levels(RowRange rows, const PyramidSpan& span) {
  unsigned level = 0;
  while (level + 1 < kPyramidLevels && (rows.end - rows.first) / rows_per_bin(level + 1) >= span.max_bins) ++level;
  const std::uint64_t bins = (rows.end - rows.first + rows_per_bin(level) - 1) / rows_per_bin(level);
  Joiner joiner((bins + span.max_bins - 1) / span.max_bins * rows_per_bin(level));
  std::uint64_t next = rows.first / rows_per_bin(level) * rows_per_bin(level);
  for (unsigned finer = 0; finer <= level && next < rows.end; ++finer) {
    const std::uint64_t width = rows_per_bin(level - finer);
    const std::uint64_t end = std::min(rows.end, rows_covered(level - finer));
    if (end <= next) continue;
    for (const LevelBin& part :
         read_bins(connection_.database(), channel_.id, level - finer, next / width, (end - 1) / width)) {
      joiner.add(part.index * width, [&](BinSum& sum) { sum.add(part.bin); });
    }
    next = end;
  }
  if (const auto added = add_samples(joiner, {next, rows.end}, span); !added) return base::forward_error(added);
  return joiner.take();
}

base::Result<std::vector<PyramidBin>> PyramidQuery::answer(const PyramidSpan& span) {
  base_bins_ = count_base_bins();
  const auto rows = rows_of(span);
  if (!rows) return base::forward_error(rows);
  if (rows->first == rows->end) return std::vector<PyramidBin>{};
  if ((rows->end - rows->first) / kBaseBinRows < span.max_bins) return from_samples(*rows, span);
  return from_levels(*rows, span);
}

}  // namespace

base::Result<std::vector<PyramidBin>> query_pyramid(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                                    const StoredStream& stream, std::size_t channel, bool finished,
                                                    const PyramidSpan& span) {
  return connection.run("read the pyramid",
                        [&] { return PyramidQuery(connection, decoder, stream, channel, finished).answer(span); });
}

base::Result<RowSpan> query_rows(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                 const StoredStream& stream, bool finished, const PyramidSpan& span) {
  return connection.run("find the rows of a span",
                        [&] { return PyramidQuery(connection, decoder, stream, 0, finished).rows(span); });
}

}  // namespace soak::db::run
