// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "db/detail/column_codec.h"
#include "db/run/detail/open_run_file.h"
#include "db/run/detail/pyramid_query.h"
#include "db/run/detail/run_file_check.h"
#include "db/run/detail/tables.h"
#include "db/run/run_file.h"

namespace soak::db {

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
