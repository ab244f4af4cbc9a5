// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "db/detail/column_codec.h"
#include "db/detail/schema.h"
#include "db/detail/sqlite.h"
#include "db/durable.h"
#include "db/run/detail/chunk_table.h"
#include "db/run/detail/open_run_file.h"
#include "db/run/detail/pyramid.h"
#include "db/run/detail/tables.h"
#include "db/run/run_file.h"

namespace soak::db {
namespace {

using run::OpenStream;

base::Status check_run(const RunInfo& info, const std::filesystem::path& path) {
  const calib::Site& site = info.site;
  bool finite = std::isfinite(info.created_utc_s) && std::isfinite(info.clock_rate);
  for (const auto& value : {site.latitude_deg, site.height_m, site.azimuth_deg, site.gravity_mps2}) {
    finite = finite && std::isfinite(value.value_or(0.0));
  }
  if (info.run_id.empty()) return base::bad_input("a run needs a run id", path.string());
  if (!finite) return base::bad_input("times, rates and site of a run must be finite numbers", path.string());
  return {};
}

base::Status prepare(const sqlite::Connection& connection, const RunInfo& info) {
  return connection.run("create the run file", [&]() -> base::Status {
    SQLite::Database& database = connection.database();
    // Half a small page is what the last page of each chunk wastes on average.
    database.exec("PRAGMA page_size = 2048");
    database.exec("PRAGMA journal_mode = WAL");
    // FULL: in WAL mode only that syncs each commit, and the catalog will refer to what flush() has committed.
    database.exec("PRAGMA synchronous = FULL");
    // Short chunks are replaced all the time and are nobody's secret.
    database.exec("PRAGMA secure_delete = OFF");
    return connection.transact("create the run file", [&]() -> base::Status {
      database.exec("PRAGMA application_id = " + std::to_string(schema::kRunFileApplicationId));
      database.exec("PRAGMA user_version = " + std::to_string(schema::kRunFileVersion));
      database.exec(schema::kRunFileSql);
      run::insert_meta(database, info);
      return {};
    });
  });
}

}  // namespace

struct RunFileWriter::Impl {
  Impl(std::filesystem::path file, sqlite::Connection opened)
      : path(std::move(file)), connection(std::make_unique<sqlite::Connection>(std::move(opened))) {}

  [[nodiscard]] base::Status restore();
  [[nodiscard]] double last_t_s() const;
  [[nodiscard]] base::Status check_open() const {
    if (connection && !finished) return {};
    return base::bad_input("the run file is sealed; a sealed file is never changed", path.string());
  }
  [[nodiscard]] base::Status check_rows(const OpenStream& stream, const std::vector<Column>& columns) const;
  [[nodiscard]] base::Status check_time(const OpenStream& stream, const Column& column) const;
  [[nodiscard]] run::ChunkTable& chunk_table();
  [[nodiscard]] base::Status write_full_chunks();
  [[nodiscard]] base::Status write_full_chunk(OpenStream& stream);
  std::vector<run::PyramidBuilder> store_window(const OpenStream& stream, std::size_t rows, bool last);
  [[nodiscard]] base::Status finish();
  [[nodiscard]] base::Status leave_wal();
  void write_short_chunks();
  void write_events();

  std::filesystem::path path;
  std::unique_ptr<sqlite::Connection> connection;  ///< absent once sealed
  bool finished = false;                           ///< all rows and the whole pyramid are stored
  std::optional<run::ChunkTable> chunks;           ///< from the first write on
  codec::ColumnEncoder encoder;
  std::vector<OpenStream> streams;
  std::vector<RunEvent> pending_events;
};

RunFileWriter::RunFileWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RunFileWriter::RunFileWriter(RunFileWriter&&) noexcept = default;
RunFileWriter& RunFileWriter::operator=(RunFileWriter&&) noexcept = default;
RunFileWriter::~RunFileWriter() = default;

base::Result<RunFileWriter> RunFileWriter::create(const std::filesystem::path& path, const RunInfo& info) {
  if (const auto valid = check_run(info, path); !valid) return base::forward_error(valid);
  if (const auto created = sqlite::create_exclusively(path); !created) return base::forward_error(created);
  auto connection = sqlite::Connection::open(path, sqlite::Access::read_write);
  base::Status status = connection ? prepare(*connection, info) : base::Status(base::forward_error(connection));
  if (status) status = sync_name(path);
  if (!status) {
    connection = base::forward_error(status);
    sqlite::remove_with_companions(path);
    return base::forward_error(status);
  }
  return RunFileWriter(std::make_unique<Impl>(path, std::move(*connection)));
}

/// Takes up the state that the file's former writer had after its last flush.
base::Status RunFileWriter::Impl::restore() {
  const auto meta = run::read_meta(*connection);
  if (!meta) return base::forward_error(meta);
  finished = meta->finished;
  if (finished) return {};
  auto stored = run::read_streams(*connection);
  if (!stored) return base::forward_error(stored);
  codec::ColumnDecoder decoder;
  for (run::StoredStream& stream : *stored) {
    auto restored = run::restored_stream(*connection, decoder, std::move(stream));
    if (!restored) return base::forward_error(restored);
    streams.push_back(*std::move(restored));
  }
  return {};
}

/// Time of the last row of all; 0 where there is none.
double RunFileWriter::Impl::last_t_s() const {
  std::optional<double> last;
  for (const OpenStream& stream : streams) last = std::max(last, stream.last_t_s);
  return last.value_or(0.0);
}

base::Result<std::string> RunFileWriter::seal_interrupted(const std::filesystem::path& path, std::string_view text) {
  auto connection = run::open_abandoned(path);
  if (!connection) return base::forward_error(connection);
  if (!*connection) return sqlite::sha256_of_file(path);
  RunFileWriter writer(std::make_unique<Impl>(path, *std::move(*connection)));
  if (const auto restored = writer.impl_->restore(); !restored) return base::forward_error(restored);
  if (!writer.impl_->finished)
    writer.impl_->pending_events.push_back({writer.impl_->last_t_s(), "interrupted", std::string(text)});
  return writer.seal();
}

base::Result<std::size_t> RunFileWriter::add_stream(const StreamInfo& stream) {
  if (const auto open = impl_->check_open(); !open) return base::forward_error(open);
  if (const auto valid = run::check_stream(stream); !valid) return base::forward_error(valid);
  for (const OpenStream& other : impl_->streams) {
    if (other.stored.info.name == stream.name && other.stored.info.unit == stream.unit) {
      return base::bad_input("the run file has a stream '" + stream.name + "' of unit '" + stream.unit + "' already",
                             impl_->path.string());
    }
  }
  auto stored = impl_->connection->transact("add a stream", [&]() -> base::Result<run::StoredStream> {
    return run::insert_stream(impl_->connection->database(), stream);
  });
  if (!stored) return base::forward_error(stored);
  impl_->streams.push_back(run::new_stream(std::move(*stored)));
  return impl_->streams.size() - 1;
}

base::Status RunFileWriter::Impl::check_rows(const OpenStream& stream, const std::vector<Column>& columns) const {
  const auto& channels = stream.stored.channels;
  if (columns.size() != channels.size()) {
    return base::bad_input(
        "the stream has " + std::to_string(channels.size()) + " channels, not " + std::to_string(columns.size()),
        path.string() + ", stream " + stream.stored.info.name);
  }
  const std::size_t rows = columns.front().rows();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = columns[i];
    const auto refused = [&](const char* message) {
      return base::bad_input(message, path.string() + ", channel " + channels[i].title);
    };
    if (column.type != channels[i].info.type) return refused("the numbers have another type");
    const bool whole = column.raw.size() == rows * size_of(column.type);
    if (!whole || (!column.present.empty() && column.present.size() != rows)) {
      return refused("the column has another length than the time axis");
    }
  }
  return check_time(stream, columns.front());
}

base::Status RunFileWriter::Impl::check_time(const OpenStream& stream, const Column& column) const {
  const run::StoredChannel& channel = stream.stored.channels.front();
  const auto refused = [&](const std::string& message) {
    return base::bad_input(message, path.string() + ", channel " + channel.title);
  };
  std::optional<double> last = stream.last_t_s;
  for (const double t_s : values_of(column, channel.info.scale, channel.info.offset)) {
    if (!std::isfinite(t_s)) return refused("every row needs a finite time");
    if (last && t_s < *last) {
      return refused("the time falls from " + std::to_string(*last) + " s to " + std::to_string(t_s) +
                     " s; rows must come in the order of time");
    }
    last = t_s;
  }
  return {};
}

run::ChunkTable& RunFileWriter::Impl::chunk_table() {
  if (!chunks) chunks.emplace(connection->database());
  return *chunks;
}

base::Status RunFileWriter::append(std::size_t stream, const std::vector<Column>& columns) {
  if (const auto open = impl_->check_open(); !open) return open;
  if (stream >= impl_->streams.size()) return base::bad_input("no such stream", impl_->path.string());
  OpenStream& target = impl_->streams[stream];
  if (const auto valid = impl_->check_rows(target, columns); !valid) return valid;
  const std::size_t rows = columns.front().rows();
  if (rows == 0) return {};
  const ChannelInfo& time = target.stored.channels.front().info;
  double last_t_s = 0.0;
  put_values(columns.front(), rows - 1, time.scale, time.offset, std::span(&last_t_s, 1));
  target.last_t_s = last_t_s;
  base::Status status;
  for (std::size_t first = 0; first < rows;) {
    const std::size_t room = run::kChunkRows - target.pending_rows() % run::kChunkRows;
    const std::size_t taken = std::min(room, rows - first);
    for (std::size_t i = 0; i < columns.size(); ++i) run::append_rows(target.pending[i], columns[i], first, taken);
    first += taken;
    if (status && target.pending_rows() >= run::kChunkRows) status = impl_->write_full_chunks();
  }
  return status;
}

/// Stores the first `rows` pending rows of a stream as one chunk per channel in place of the short ones, with the bins
/// of the pyramid that they complete. `last`: no rows will follow. Returns the pyramids' new state. Throws
/// SQLite::Exception.
std::vector<run::PyramidBuilder> RunFileWriter::Impl::store_window(const OpenStream& stream, std::size_t rows,
                                                                   bool last) {
  SQLite::Database& database = connection->database();
  auto pyramids = stream.pyramids;
  std::vector<double> t_s;
  for (std::size_t i = 0; i < stream.pending.size(); ++i) {
    const run::StoredChannel& channel = stream.stored.channels[i];
    const Column column = run::rows_of(stream.pending[i], 0, rows);
    chunk_table().remove_from(channel.id, stream.pending_first_row);
    if (rows > 0) chunk_table().insert(channel.id, stream.pending_first_row, encoder.encode(column));
    const auto values = values_of(column, channel.info.scale, channel.info.offset);
    if (i == 0) t_s = values;
    std::vector<run::LevelBin> bins;
    pyramids[i].add(t_s, values, bins);
    if (last) pyramids[i].finish(bins);
    run::insert_bins(database, channel.id, bins);
  }
  return pyramids;
}

base::Status RunFileWriter::Impl::write_full_chunk(OpenStream& stream) {
  auto pyramids = connection->transact("store samples", [&]() -> base::Result<std::vector<run::PyramidBuilder>> {
    return store_window(stream, run::kChunkRows, false);
  });
  if (!pyramids) return base::forward_error(pyramids);
  stream.pyramids = std::move(*pyramids);
  for (Column& column : stream.pending) run::drop_first_rows(column, run::kChunkRows);
  stream.pending_first_row += run::kChunkRows;
  stream.flushed = 0;
  return {};
}

base::Status RunFileWriter::Impl::write_full_chunks() {
  for (OpenStream& stream : streams) {
    while (stream.pending_rows() >= run::kChunkRows) {
      if (const auto written = write_full_chunk(stream); !written) return written;
    }
  }
  return {};
}

void RunFileWriter::Impl::write_short_chunks() {
  for (const OpenStream& stream : streams) {
    const std::size_t rows = stream.pending_rows() - stream.flushed;
    if (rows == 0) continue;
    for (std::size_t i = 0; i < stream.pending.size(); ++i) {
      const Column column = run::rows_of(stream.pending[i], stream.flushed, rows);
      chunk_table().insert(stream.stored.channels[i].id, stream.pending_first_row + stream.flushed,
                           encoder.encode(column, codec::Effort::quick));
    }
  }
}

void RunFileWriter::Impl::write_events() {
  for (const RunEvent& event : pending_events) run::insert_event(connection->database(), event);
}

base::Status RunFileWriter::add_event(double t_s, std::string_view kind, std::string_view text) {
  if (const auto open = impl_->check_open(); !open) return open;
  if (!std::isfinite(t_s)) return base::bad_input("the time of an event must be finite", impl_->path.string());
  impl_->pending_events.push_back({t_s, std::string(kind), std::string(text)});
  return {};
}

base::Status RunFileWriter::flush() {
  if (const auto open = impl_->check_open(); !open) return open;
  if (const auto written = impl_->write_full_chunks(); !written) return written;
  auto committed = impl_->connection->transact("store samples", [&]() -> base::Status {
    impl_->write_short_chunks();
    impl_->write_events();
    return {};
  });
  if (!committed) return committed;
  for (OpenStream& stream : impl_->streams) stream.flushed = stream.pending_rows();
  impl_->pending_events.clear();
  return {};
}

base::Status RunFileWriter::Impl::finish() {
  if (const auto written = write_full_chunks(); !written) return written;
  auto committed = connection->transact("finish the run file", [&]() -> base::Status {
    for (const OpenStream& stream : streams) store_window(stream, stream.pending_rows(), true);
    write_events();
    run::insert_finished(connection->database());
    return {};
  });
  finished = committed.has_value();
  return committed;
}

/// Moves everything into the one file and ends WAL mode, which a read-only folder could not serve.
base::Status RunFileWriter::Impl::leave_wal() {
  return connection->run("seal the run file", [&]() -> base::Status {
    SQLite::Database& database = connection->database();
    SQLite::Statement checkpoint(database, "PRAGMA wal_checkpoint(TRUNCATE)");
    const bool blocked = checkpoint.executeStep() && checkpoint.getColumn(0).getInt() != 0;
    checkpoint.reset();
    const std::string mode = blocked ? "wal" : database.execAndGet("PRAGMA journal_mode = DELETE").getString();
    if (mode == "delete") return {};
    return base::fail(base::ErrorKind::internal,
                      "cannot seal the run file: another process reads it; close it there and seal again",
                      path.string());
  });
}

base::Result<std::string> RunFileWriter::seal() {
  if (!impl_->connection) return base::bad_input("the run file is sealed already", impl_->path.string());
  if (!impl_->finished) {
    if (const auto finished = impl_->finish(); !finished) return base::forward_error(finished);
  }
  impl_->chunks.reset();
  if (const auto left = impl_->leave_wal(); !left) return base::forward_error(left);
  impl_->connection.reset();
  if (const auto synced = sync_to_disk(impl_->path); !synced) return base::forward_error(synced);
  if (const auto named = sync_name(impl_->path); !named) return base::forward_error(named);
  return sqlite::sha256_of_file(impl_->path);
}

}  // namespace soak::db
