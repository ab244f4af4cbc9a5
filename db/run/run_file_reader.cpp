// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "base/hash.h"
#include "db/detail/column_codec.h"
#include "db/run/detail/open_run_file.h"
#include "db/run/detail/pyramid.h"
#include "db/run/detail/tables.h"
#include "db/run/run_file.h"

namespace soak::db {
namespace run {
namespace {

/// Rows that are in memory at a time.
constexpr std::uint64_t kSlabRows = 16 * kChunkRows;

/// Calls `use(slab)` for all rows of a channel in order, slab by slab.
base::Status for_each_slab(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                           const StoredChannel& channel, std::uint64_t rows,
                           const std::function<base::Status(const Column&)>& use) {
  for (std::uint64_t first = 0; first < rows; first += kSlabRows) {
    const auto slab = read_rows(connection, decoder, channel, first, std::min(kSlabRows, rows - first));
    if (!slab) return base::forward_error(slab);
    if (const auto used = use(*slab); !used) return used;
  }
  return {};
}

/// Text after its length, so that no two lists of texts look alike.
void hash_text(base::Sha256& hash, std::string_view text) {
  base::ByteWriter length;
  length.write(static_cast<std::uint64_t>(text.size()));
  hash.update(length.bytes());
  hash.update(text);
}

template <class Number>
void hash_number(base::Sha256& hash, Number number) {
  base::ByteWriter bytes;
  bytes.write(number);
  hash.update(bytes.bytes());
}

void hash_meaning(base::Sha256& hash, const ChannelInfo& info) {
  hash_text(hash, info.name);
  hash_text(hash, name_of(info.type));
  hash_text(hash, info.unit);
  hash_number(hash, info.scale);
  hash_number(hash, info.offset);
  hash_number(hash, static_cast<std::uint64_t>(info.labels.size()));
  for (const std::string& label : info.labels) hash_text(hash, label);
}

/// Hashes of the numbers and of the presence bytes: two, because slabs must not show in the result.
base::Status hash_numbers(base::Sha256& hash, const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                          const StoredChannel& channel, std::uint64_t rows) {
  base::Sha256 numbers;
  base::Sha256 presence;
  auto read = for_each_slab(connection, decoder, channel, rows, [&](const Column& slab) -> base::Status {
    numbers.update(slab.raw);
    presence.update(slab.present.empty() ? std::vector<std::uint8_t>(slab.rows(), 1) : slab.present);
    return {};
  });
  if (!read) return read;
  hash.update(numbers.finish());
  hash.update(presence.finish());
  return {};
}

std::vector<double> scaled(const Column& column, const ChannelInfo& info) {
  return values_of(column, info.scale, info.offset);
}

/// The time axis of a stream, which is finite and never falls.
base::Result<std::vector<double>> checked_times(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                                const StoredStream& stream) {
  const StoredChannel& channel = stream.channels.front();
  std::vector<double> t_s;
  const auto read = for_each_slab(connection, decoder, channel, stream.rows, [&](const Column& slab) -> base::Status {
    const auto values = scaled(slab, channel.info);
    t_s.insert(t_s.end(), values.begin(), values.end());
    return {};
  });
  if (!read) return base::forward_error(read);
  const bool finite = std::all_of(t_s.begin(), t_s.end(), [](double t) { return std::isfinite(t); });
  if (!finite || !std::is_sorted(t_s.begin(), t_s.end())) {
    return base::corrupt("the time axis is not finite or decreases",
                         connection.path().string() + ", channel " + channel.title);
  }
  return t_s;
}

bool same(const LevelBin& a, const LevelBin& b) {
  // Sums in another order may differ in the last bits of the mean, and in nothing else.
  const double tolerance = 1e-9 * std::max(std::fabs(a.bin.minimum), std::fabs(a.bin.maximum));
  return a.level == b.level && a.index == b.index && a.bin.count == b.bin.count && a.bin.t_first_s == b.bin.t_first_s &&
         a.bin.t_last_s == b.bin.t_last_s && a.bin.minimum == b.bin.minimum && a.bin.maximum == b.bin.maximum &&
         std::fabs(a.bin.mean - b.bin.mean) <= tolerance;
}

base::Status compare_bins(const sqlite::Connection& connection, const StoredChannel& channel,
                          std::vector<LevelBin> expected) {
  return connection.run("check the pyramid", [&]() -> base::Status {
    std::erase_if(expected, [](const LevelBin& bin) { return bin.bin.count == 0; });
    std::sort(expected.begin(), expected.end(), [](const LevelBin& a, const LevelBin& b) {
      return std::tie(a.level, a.index) < std::tie(b.level, b.index);
    });
    std::vector<LevelBin> stored;
    for (unsigned level = 0; level < kPyramidLevels; ++level) {
      const auto bins = read_bins(connection.database(), channel.id, level, 0, INT64_MAX);
      stored.insert(stored.end(), bins.begin(), bins.end());
    }
    if (std::equal(stored.begin(), stored.end(), expected.begin(), expected.end(), same)) return {};
    return base::corrupt("the pyramid does not match the samples",
                         connection.path().string() + ", channel " + channel.title);
  });
}

base::Status check_channel(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                           const StoredChannel& channel, const std::vector<double>& t_s, bool finished) {
  const auto rows = stored_rows(connection, channel);
  if (!rows) return base::forward_error(rows);
  if (*rows != t_s.size()) {
    return base::corrupt("the channel has another number of rows than its time axis",
                         connection.path().string() + ", channel " + channel.title);
  }
  PyramidBuilder builder;
  std::vector<LevelBin> bins;
  const std::size_t covered = finished ? t_s.size() : t_s.size() / kChunkRows * kChunkRows;
  std::size_t next = 0;
  auto read = for_each_slab(connection, decoder, channel, t_s.size(), [&](const Column& slab) -> base::Status {
    const auto values = scaled(slab, channel.info);
    const std::size_t count = std::min(values.size(), covered - std::min(covered, next));
    builder.add(std::span(t_s).subspan(next, count), std::span(values).first(count), bins);
    next += values.size();
    return {};
  });
  if (!read) return read;
  if (finished) builder.finish(bins);
  return compare_bins(connection, channel, std::move(bins));
}

/// See RunFileReader::content_hash().
base::Result<std::string> content_hash_of(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                          const std::vector<StoredStream>& streams) {
  std::vector<std::reference_wrapper<const StoredStream>> sorted(streams.begin(), streams.end());
  std::sort(sorted.begin(), sorted.end(), [](const StoredStream& a, const StoredStream& b) {
    return std::tie(a.info.name, a.info.unit) < std::tie(b.info.name, b.info.unit);
  });
  base::Sha256 hash;
  for (const StoredStream& stream : sorted) {
    hash_text(hash, stream.info.name);
    hash_text(hash, stream.info.unit);
    hash_number(hash, stream.rows);
    hash_number(hash, static_cast<std::uint64_t>(stream.channels.size()));
    for (const StoredChannel& channel : stream.channels) {
      hash_meaning(hash, channel.info);
      const auto hashed = hash_numbers(hash, connection, decoder, channel, stream.rows);
      if (!hashed) return base::forward_error(hashed);
    }
  }
  return base::to_hex(hash.finish());
}

/// Every chunk's checksum, the row counts, the order of time, and the pyramid against the samples. `finished`: the
/// pyramid covers all rows; otherwise it covers full chunks.
base::Status check_samples(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                           const std::vector<StoredStream>& streams, bool finished) {
  for (const StoredStream& stream : streams) {
    const auto t_s = checked_times(connection, decoder, stream);
    if (!t_s) return base::forward_error(t_s);
    for (const StoredChannel& channel : stream.channels) {
      const auto checked = check_channel(connection, decoder, channel, *t_s, finished);
      if (!checked) return checked;
    }
  }
  return {};
}

}  // namespace
}  // namespace run

struct RunFileReader::Impl {
  explicit Impl(run::OpenedRunFile opened) : file(std::move(opened)) {}

  [[nodiscard]] base::Status check_place(std::size_t stream, std::size_t channel) const {
    if (stream < streams.size() && channel < streams[stream].channels.size()) return {};
    return base::bad_input("the run file has no such stream or channel", file.connection.path().string());
  }

  run::OpenedRunFile file;
  run::Meta meta;
  std::vector<run::StoredStream> streams;
  std::vector<StreamInfo> infos;
  codec::ColumnDecoder decoder;
};

RunFileReader::RunFileReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RunFileReader::RunFileReader(RunFileReader&&) noexcept = default;
RunFileReader& RunFileReader::operator=(RunFileReader&&) noexcept = default;
RunFileReader::~RunFileReader() = default;

base::Result<RunFileReader> RunFileReader::open(const std::filesystem::path& path) {
  auto file = run::open_run_file(path);
  if (!file) return base::forward_error(file);
  auto impl = std::make_unique<Impl>(std::move(*file));
  auto meta = run::read_meta(impl->file.connection);
  if (!meta) return base::forward_error(meta);
  auto streams = run::read_streams(impl->file.connection);
  if (!streams) return base::forward_error(streams);
  impl->meta = std::move(*meta);
  impl->streams = std::move(*streams);
  for (const run::StoredStream& stream : impl->streams) impl->infos.push_back(stream.info);
  return RunFileReader(std::move(impl));
}

const RunInfo& RunFileReader::info() const { return impl_->meta.info; }
bool RunFileReader::sealed() const { return impl_->file.sealed; }
const std::vector<StreamInfo>& RunFileReader::streams() const { return impl_->infos; }
std::uint64_t RunFileReader::rows(std::size_t stream) const { return impl_->streams.at(stream).rows; }

base::Result<std::vector<RunEvent>> RunFileReader::events() const { return run::read_events(impl_->file.connection); }

base::Result<Column> RunFileReader::read(std::size_t stream, std::size_t channel, std::uint64_t first_row,
                                         std::uint64_t count) const {
  if (const auto valid = impl_->check_place(stream, channel); !valid) return base::forward_error(valid);
  const run::StoredStream& stored = impl_->streams[stream];
  const std::uint64_t first = std::min(first_row, stored.rows);
  return run::read_rows(impl_->file.connection, impl_->decoder, stored.channels[channel], first,
                        std::min(count, stored.rows - first));
}

base::Status RunFileReader::scan(std::size_t stream, std::size_t channel,
                                 const std::function<void(std::span<const double>)>& take) const {
  if (auto valid = impl_->check_place(stream, channel); !valid) return valid;
  const run::StoredStream& stored = impl_->streams[stream];
  const ChannelInfo& info = stored.channels[channel].info;
  std::vector<double> values;
  return run::for_each_chunk(impl_->file.connection, impl_->decoder, stored.channels[channel], 0, stored.rows,
                             [&](const Column& chunk, std::size_t first, std::size_t count) {
                               values.resize(count);
                               put_values(chunk, first, info.scale, info.offset, values);
                               take(values);
                             });
}

base::Result<RowSpan> RunFileReader::rows_between(std::size_t stream, double from_s, double to_s) const {
  if (const auto valid = impl_->check_place(stream, 0); !valid) return base::forward_error(valid);
  if (!(from_s <= to_s)) {
    return base::bad_input("the span must not end before it starts", impl_->file.connection.path().string());
  }
  return run::query_rows(impl_->file.connection, impl_->decoder, impl_->streams[stream], impl_->meta.finished,
                         {from_s, to_s, 1});
}

base::Result<std::vector<PyramidBin>> RunFileReader::pyramid(std::size_t stream, std::size_t channel, double from_s,
                                                             double to_s, std::size_t max_bins) const {
  if (const auto valid = impl_->check_place(stream, channel); !valid) return base::forward_error(valid);
  if (!(from_s <= to_s) || max_bins == 0) {
    return base::bad_input("the span must not end before it starts, and at least one bin must be asked for",
                           impl_->file.connection.path().string());
  }
  return run::query_pyramid(impl_->file.connection, impl_->decoder, impl_->streams[stream], channel,
                            impl_->meta.finished, {from_s, to_s, max_bins});
}

base::Result<std::string> RunFileReader::content_hash() const {
  return run::content_hash_of(impl_->file.connection, impl_->decoder, impl_->streams);
}

base::Status RunFileReader::verify() const {
  const sqlite::Connection& connection = impl_->file.connection;
  if (const auto whole = connection.integrity_check(); !whole) return whole;
  return connection.run("check the run file", [&]() -> base::Status {
    // One snapshot: the file may be growing.
    const SQLite::Transaction snapshot(connection.database());
    const auto meta = run::read_meta(connection);
    if (!meta) return base::forward_error(meta);
    const auto streams = run::read_streams(connection);
    if (!streams) return base::forward_error(streams);
    return run::check_samples(connection, impl_->decoder, *streams, meta->finished);
  });
}

}  // namespace soak::db
