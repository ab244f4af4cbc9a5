// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "db/detail/sqlite.h"
#include "db/run/detail/chunk_table.h"
#include "db/run/run_file.h"

/// The tables `meta`, `stream`, `channel` and `event` of a run file.
namespace soak::db::run {

struct StoredStream {
  StreamInfo info;
  std::vector<StoredChannel> channels;
  std::uint64_t rows = 0;
};

/// Writes what a run says of itself. Throws SQLite::Exception.
void insert_meta(SQLite::Database& database, const RunInfo& info);
/// Marks the file as finished: its pyramid is complete. Throws SQLite::Exception.
void insert_finished(SQLite::Database& database);

struct Meta {
  RunInfo info;
  bool finished = false;
};
[[nodiscard]] base::Result<Meta> read_meta(const sqlite::Connection& connection);

/// Refuses a description that has no meaning: no time axis, names twice, scales that are not finite.
[[nodiscard]] base::Status check_stream(const StreamInfo& info);
/// Stores the description. Throws SQLite::Exception.
[[nodiscard]] StoredStream insert_stream(SQLite::Database& database, const StreamInfo& info);
/// All streams with the number of rows of their time axis.
[[nodiscard]] base::Result<std::vector<StoredStream>> read_streams(const sqlite::Connection& connection);

/// Stores an event. Throws SQLite::Exception.
void insert_event(SQLite::Database& database, const RunEvent& event);
[[nodiscard]] base::Result<std::vector<RunEvent>> read_events(const sqlite::Connection& connection);

}  // namespace soak::db::run
