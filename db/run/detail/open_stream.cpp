// SPDX-License-Identifier: Apache-2.0
#include "db/run/detail/open_stream.h"

#include <utility>

#include "db/run/detail/layout.h"

namespace soak::db::run {
namespace {

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
