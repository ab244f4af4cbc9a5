// SPDX-License-Identifier: Apache-2.0
#include "db/run/detail/open_run_file.h"

#include <string>
#include <system_error>
#include <utility>

#include "db/detail/schema.h"

namespace soak::db::run {
namespace {

std::filesystem::path companion(const std::filesystem::path& path, const char* suffix) {
  return std::filesystem::path(path) += suffix;
}

bool holds_bytes(const std::filesystem::path& path) {
  std::error_code absent;
  const auto size = std::filesystem::file_size(path, absent);
  return !absent && size > 0;
}

base::Status check_run_file_identity(const sqlite::Connection& connection) {
  const auto identity = connection.identity();
  if (!identity) return base::forward_error(identity);
  return schema::check_identity(*identity, schema::kRunFileApplicationId, schema::kRunFileVersion, "run file",
                                connection.path());
}

/// In a file from elsewhere a view could stand in for a table and never end.
base::Status check_tables(const sqlite::Connection& connection) {
  return connection.run("read the schema", [&]() -> base::Status {
    SQLite::Statement query(
        connection.database(),
        "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND sql NOT LIKE 'CREATE VIRTUAL%' "
        "AND name IN ('meta', 'stream', 'channel', 'chunk', 'pyramid', 'event')");
    query.executeStep();
    if (query.getColumn(0).getInt() == 6) return {};
    return base::corrupt("the run file lacks tables", connection.path().string());
  });
}

base::Result<OpenedRunFile> open_as(const std::filesystem::path& path, sqlite::Access access, bool sealed) {
  auto connection = sqlite::Connection::open(path, access);
  if (!connection) return base::forward_error(connection);
  if (const auto ours = check_run_file_identity(*connection); !ours) return base::forward_error(ours);
  if (const auto tables = check_tables(*connection); !tables) return base::forward_error(tables);
  return OpenedRunFile{std::move(*connection), sealed};
}

/// A file that is still written is in WAL mode and read with locks. Where that fails because nothing can be created
/// beside it, the main file is all there is if no -wal file holds more.
base::Result<OpenedRunFile> open_unsealed(const std::filesystem::path& path) {
  auto shared = open_as(path, sqlite::Access::read_only, false);
  if (shared || shared.error().kind != base::ErrorKind::internal) return shared;
  if (!holds_bytes(companion(path, "-wal"))) return open_as(path, sqlite::Access::immutable, false);
  shared.error().message +=
      "; the run file is not sealed: copy it with its -wal file into a folder that can be written";
  return shared;
}

/// Takes the file for this connection alone; no statement may have read it yet. In WAL mode every connection holds a
/// shared lock as long as it lives, so that this fails while there is another one.
base::Status take_alone(const sqlite::Connection& connection) {
  constexpr int kPatience_ms = 500;  // a reader may be about to close the file, a writer is not
  auto taken = connection.run("open the run file", [&]() -> base::Status {
    connection.database().setBusyTimeout(kPatience_ms);
    connection.database().exec("PRAGMA locking_mode = EXCLUSIVE");
    connection.database().exec("PRAGMA synchronous = FULL");
    connection.database().execAndGet("SELECT count(*) FROM sqlite_master");
    return {};
  });
  if (taken || taken.error().kind != base::ErrorKind::internal) return taken;
  return base::bad_input(taken.error().message + "; a run file that is still written cannot be taken over",
                         connection.path().string());
}

bool is_wal(const sqlite::Connection& connection) {
  return connection.database().execAndGet("PRAGMA journal_mode").getString() == "wal";
}

/// Whether the file says that it is sealed: no WAL mode and no journal that a crash has left.
base::Result<bool> says_sealed(const std::filesystem::path& path) {
  const auto header = sqlite::read_header(path);
  if (!header) return base::forward_error(header);
  if (header->empty) return base::bad_input("there is no run file here", path.string());
  return !header->wal && !holds_bytes(companion(path, "-journal"));
}

base::Result<std::vector<double>> read_values(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                              const StoredChannel& channel, std::uint64_t first_row,
                                              std::uint64_t count) {
  const auto column = read_rows(connection, decoder, channel, first_row, count);
  if (!column) return base::forward_error(column);
  return values_of(*column, channel.info.scale, channel.info.offset);
}

/// Shows the pyramids the rows of one full chunk, whose bins are stored.
base::Status pass_chunk(const sqlite::Connection& connection, codec::ColumnDecoder& decoder, OpenStream& stream,
                        std::uint64_t first_row) {
  std::vector<double> t_s;
  for (std::size_t i = 0; i < stream.pyramids.size(); ++i) {
    const auto values = read_values(connection, decoder, stream.stored.channels[i], first_row, kChunkRows);
    if (!values) return base::forward_error(values);
    if (i == 0) t_s = *values;
    std::vector<LevelBin> stored_already;
    stream.pyramids[i].add(t_s, *values, stored_already);
  }
  return {};
}

base::Status read_pending(const sqlite::Connection& connection, codec::ColumnDecoder& decoder, OpenStream& stream) {
  const std::uint64_t rows = stream.stored.rows;
  stream.flushed = rows - stream.pending_first_row;
  for (std::size_t i = 0; i < stream.pending.size(); ++i) {
    auto column = read_rows(connection, decoder, stream.stored.channels[i], stream.pending_first_row, stream.flushed);
    if (!column) return base::forward_error(column);
    stream.pending[i] = *std::move(column);
  }
  if (rows == 0) return {};
  const auto last = read_values(connection, decoder, stream.stored.channels.front(), rows - 1, 1);
  if (!last) return base::forward_error(last);
  stream.last_t_s = last->front();
  return {};
}

}  // namespace

base::Result<std::optional<sqlite::Connection>> open_abandoned(const std::filesystem::path& path) {
  const auto sealed = says_sealed(path);
  if (!sealed) return base::forward_error(sealed);
  if (*sealed) return std::nullopt;
  auto connection = sqlite::Connection::open(path, sqlite::Access::read_write);
  if (!connection) return base::forward_error(connection);
  if (const auto alone = take_alone(*connection); !alone) return base::forward_error(alone);
  if (const auto ours = check_run_file_identity(*connection); !ours) return base::forward_error(ours);
  if (const auto tables = check_tables(*connection); !tables) return base::forward_error(tables);
  return connection->run("open the run file", [&]() -> base::Result<std::optional<sqlite::Connection>> {
    if (!is_wal(*connection)) return std::nullopt;
    return std::optional(std::move(*connection));
  });
}

base::Result<OpenedRunFile> open_run_file(const std::filesystem::path& path) {
  const auto header = sqlite::read_header(path);
  if (!header) return base::forward_error(header);
  if (header->empty) return base::bad_input("there is no run file here", path.string());
  if (header->wal) return open_unsealed(path);
  // A journal that a crash while sealing left must be rolled back, which needs locks.
  const bool interrupted = holds_bytes(companion(path, "-journal"));
  std::error_code error;
  if (!interrupted && std::filesystem::file_size(path, error) < header->stated_size && !error) {
    return base::corrupt("the file is cut short; restore it from a backup", path.string());
  }
  return open_as(path, interrupted ? sqlite::Access::read_only : sqlite::Access::immutable, true);
}

OpenStream new_stream(StoredStream stored) {
  OpenStream stream;
  for (const StoredChannel& channel : stored.channels) stream.pending.push_back(Column{channel.info.type, {}, {}});
  stream.pyramids.resize(stored.channels.size());
  stream.stored = std::move(stored);
  return stream;
}

base::Result<OpenStream> restored_stream(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                         StoredStream stored) {
  OpenStream stream = new_stream(std::move(stored));
  stream.pending_first_row = stream.stored.rows - stream.stored.rows % kChunkRows;
  for (std::uint64_t first = 0; first < stream.pending_first_row; first += kChunkRows) {
    if (const auto passed = pass_chunk(connection, decoder, stream, first); !passed) return base::forward_error(passed);
  }
  if (const auto read = read_pending(connection, decoder, stream); !read) return base::forward_error(read);
  return stream;
}

}  // namespace soak::db::run
