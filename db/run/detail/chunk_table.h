// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "base/result.h"
#include "db/detail/column_codec.h"
#include "db/detail/sqlite.h"
#include "db/run/sample.h"

/// The table `chunk` of a run file, and rows of columns.
namespace soak::db::run {

/// Appends rows `first` ... `first + count - 1` of `from` to `to`, which has the same type. Bytes of absent rows become
/// zero; `to.present` stays empty as long as all rows are present.
void append_rows(Column& to, const Column& from, std::size_t first, std::size_t count);

/// Rows of `column` as a column of their own.
[[nodiscard]] Column rows_of(const Column& column, std::size_t first, std::size_t count);

/// Removes the first `count` rows.
void drop_first_rows(Column& column, std::size_t count);

/// A channel as the tables know it.
struct StoredChannel {
  std::int64_t id = 0;
  std::string title;  ///< for messages: "imu/SN1/gyro_x"
  ChannelInfo info;
};

/// Writes the table, with statements that SQLite prepares once. It must end before its connection does. All of it
/// throws SQLite::Exception.
class ChunkTable {
 public:
  explicit ChunkTable(const SQLite::Database& database);

  void insert(std::int64_t channel_id, std::uint64_t first_row, const codec::EncodedColumn& encoded);
  /// Removes the channel's chunks from `first_row` on.
  void remove_from(std::int64_t channel_id, std::uint64_t first_row);

 private:
  SQLite::Statement insert_;
  SQLite::Statement remove_;
};

/// Rows that the channel's chunks claim to cover; corrupt if they cannot hold so many.
[[nodiscard]] base::Result<std::uint64_t> stored_rows(const sqlite::Connection& connection,
                                                      const StoredChannel& channel);

/// Given the rows first ... first + count - 1 of a chunk, which lives until it returns.
using ChunkRows = std::function<void(const Column& chunk, std::size_t first, std::size_t count)>;

/// Calls `use` for rows first_row ... first_row + count - 1 in order; corrupt, naming channel and chunk, where one of
/// them is missing or damaged: rows before it have been used then.
[[nodiscard]] base::Status for_each_chunk(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                          const StoredChannel& channel, std::uint64_t first_row, std::uint64_t count,
                                          const ChunkRows& use);

/// Rows first_row ... first_row + count - 1; corrupt, naming channel and chunk, where one of them is missing or
/// damaged.
[[nodiscard]] base::Result<Column> read_rows(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                             const StoredChannel& channel, std::uint64_t first_row,
                                             std::uint64_t count);

}  // namespace soak::db::run
