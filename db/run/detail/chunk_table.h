// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "base/result.h"
#include "db/detail/column_codec.h"
#include "db/detail/connection.h"
#include "db/run/sample.h"

/// The table `chunk` of a run file.
namespace soak::db::run {

/// A channel as the tables know it.
struct StoredChannel {
  std::int64_t id = 0;
  std::string title;  ///< for messages: "imu/SN1/gyro_x"
  ChannelInfo info;
};

/// Stores one chunk. Throws SQLite::Exception.
void insert_chunk(SQLite::Database& database, std::int64_t channel_id, std::uint64_t first_row,
                  const codec::EncodedColumn& encoded);

/// Removes the channel's chunks from `first_row` on. Throws SQLite::Exception.
void remove_chunks_from(SQLite::Database& database, std::int64_t channel_id, std::uint64_t first_row);

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
