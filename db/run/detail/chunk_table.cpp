// SPDX-License-Identifier: Apache-2.0
#include "db/run/detail/chunk_table.h"

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "db/detail/sqlite.h"

namespace soak::db::run {
namespace {

std::ptrdiff_t signed_of(std::size_t count) { return static_cast<std::ptrdiff_t>(count); }

bool all_present(const Column& column, std::size_t first, std::size_t count) {
  if (column.present.empty()) return true;
  const auto begin = column.present.begin() + signed_of(first);
  return std::none_of(begin, begin + signed_of(count), [](std::uint8_t present) { return present == 0; });
}

/// A row of the table; the statement owns the bytes, this the name of the codec.
struct StoredChunk {
  std::uint64_t first_row = 0;
  std::uint32_t crc32c = 0;
  std::string codec;
  codec::StoredColumn encoded;
};

std::string place_of(const sqlite::Connection& connection, const StoredChannel& channel, std::uint64_t row) {
  return connection.path().string() + ", channel " + channel.title + ", chunk at row " + std::to_string(row);
}

void take_chunk(SQLite::Statement& query, StoredChunk& chunk) {
  sqlite::Fields fields(query);
  chunk.first_row = static_cast<std::uint64_t>(fields.integer());
  chunk.encoded.rows = static_cast<std::uint64_t>(fields.integer());
  chunk.encoded.values = static_cast<std::uint64_t>(fields.integer());
  chunk.codec = fields.text();
  chunk.encoded.codec = chunk.codec;
  chunk.crc32c = static_cast<std::uint32_t>(fields.integer());
  chunk.encoded.presence = fields.blob();
  chunk.encoded.data = fields.blob();
}

base::Status decode(codec::ColumnDecoder& decoder, const StoredChannel& channel, const StoredChunk& chunk,
                    Column& column) {
  if (codec::checksum_of(chunk.encoded, channel.id, chunk.first_row) != chunk.crc32c) {
    return base::corrupt("the stored bytes fail their checksum");
  }
  return decoder.decode(chunk.encoded, channel.info.type, column);
}

}  // namespace

void append_rows(Column& to, const Column& from, std::size_t first, std::size_t count) {
  const std::size_t size = size_of(from.type);
  const std::size_t rows_before = to.rows();
  const auto raw = from.raw.begin() + signed_of(first * size);
  to.raw.insert(to.raw.end(), raw, raw + signed_of(count * size));
  const bool complete = all_present(from, first, count);
  if (complete && to.present.empty()) return;
  to.present.resize(rows_before, 1);
  to.present.resize(rows_before + count, 1);
  if (complete) return;
  for (std::size_t row = 0; row < count; ++row) {
    if (from.present[first + row] != 0) continue;
    to.present[rows_before + row] = 0;
    std::fill_n(to.raw.begin() + signed_of((rows_before + row) * size), size, std::uint8_t{0});
  }
}

Column rows_of(const Column& column, std::size_t first, std::size_t count) {
  Column part{column.type, {}, {}};
  append_rows(part, column, first, count);
  return part;
}

void drop_first_rows(Column& column, std::size_t count) {
  column.raw.erase(column.raw.begin(), column.raw.begin() + signed_of(count * size_of(column.type)));
  if (!column.present.empty()) {
    column.present.erase(column.present.begin(), column.present.begin() + signed_of(count));
  }
}

ChunkTable::ChunkTable(const SQLite::Database& database)
    : insert_(database,
              "INSERT INTO chunk (channel_id, first_row, row_count, value_count, codec, crc32c, presence, data) "
              "VALUES (?, ?, ?, ?, ?, ?, ?, ?)"),
      remove_(database, "DELETE FROM chunk WHERE channel_id = ? AND first_row >= ?") {}

void ChunkTable::insert(std::int64_t channel_id, std::uint64_t first_row, const codec::EncodedColumn& encoded) {
  insert_.tryReset();
  sqlite::Binder binder(insert_);
  binder.add(channel_id).add(first_row).add(encoded.rows).add(encoded.values).add(encoded.codec);
  binder.add(codec::checksum_of(encoded, channel_id, first_row));
  if (encoded.presence.empty()) {
    binder.add_null();
  } else {
    binder.add(encoded.presence);
  }
  binder.add(encoded.data);
  insert_.exec();
  insert_.reset();
}

void ChunkTable::remove_from(std::int64_t channel_id, std::uint64_t first_row) {
  remove_.tryReset();
  sqlite::bind_all(remove_, channel_id, first_row);
  remove_.exec();
  remove_.reset();
}

base::Result<std::uint64_t> stored_rows(const sqlite::Connection& connection, const StoredChannel& channel) {
  return connection.run("count the rows", [&]() -> base::Result<std::uint64_t> {
    SQLite::Statement query(connection.database(),
                            "SELECT coalesce(max(first_row + row_count), 0), count(*) FROM chunk WHERE channel_id = ?");
    sqlite::bind_all(query, channel.id);
    query.executeStep();
    sqlite::Fields fields(query);
    const std::int64_t rows = fields.integer();
    const std::int64_t chunks = fields.integer();
    if (rows < 0 || static_cast<std::uint64_t>(rows) > static_cast<std::uint64_t>(chunks) * codec::kMaxChunkRows) {
      return base::corrupt("the chunks claim rows that they cannot hold",
                           connection.path().string() + ", channel " + channel.title);
    }
    return static_cast<std::uint64_t>(rows);
  });
}

base::Status for_each_chunk(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                            const StoredChannel& channel, std::uint64_t first_row, std::uint64_t count,
                            const ChunkRows& use) {
  return connection.run("read samples", [&]() -> base::Status {
    SQLite::Statement query(connection.database(),
                            "SELECT first_row, row_count, value_count, codec, crc32c, presence, data FROM chunk "
                            "WHERE channel_id = ? AND first_row > ? AND first_row < ? ORDER BY first_row");
    // The chunk that holds first_row starts less than kMaxChunkRows before it.
    const auto lowest = static_cast<std::int64_t>(first_row) - static_cast<std::int64_t>(codec::kMaxChunkRows);
    sqlite::bind_all(query, channel.id, lowest, first_row + count);
    StoredChunk chunk;
    Column column;
    std::uint64_t next = first_row;
    const std::uint64_t end = first_row + count;
    while (next < end && query.executeStep()) {
      take_chunk(query, chunk);
      const std::uint64_t chunk_end = chunk.first_row + chunk.encoded.rows;
      if (next == first_row && chunk_end <= next) continue;
      if (chunk.first_row > next || chunk_end <= next || (next > first_row && chunk.first_row != next)) break;
      if (const auto decoded = decode(decoder, channel, chunk, column); !decoded) {
        return base::corrupt(decoded.error().message, place_of(connection, channel, chunk.first_row));
      }
      const std::uint64_t taken = std::min(end, chunk_end) - next;
      use(column, next - chunk.first_row, taken);
      next += taken;
    }
    if (next < end) {
      return base::corrupt("rows from " + std::to_string(next) + " on are missing",
                           place_of(connection, channel, next));
    }
    return {};
  });
}

base::Result<Column> read_rows(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                               const StoredChannel& channel, std::uint64_t first_row, std::uint64_t count) {
  Column rows{channel.info.type, {}, {}};
  const auto read = for_each_chunk(
      connection, decoder, channel, first_row, count,
      [&](const Column& column, std::size_t first, std::size_t taken) { append_rows(rows, column, first, taken); });
  if (!read) return base::forward_error(read);
  return rows;
}

}  // namespace soak::db::run
