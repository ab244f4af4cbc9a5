// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "base/result.h"
#include "db/detail/column_codec.h"
#include "db/detail/sqlite.h"
#include "db/run/detail/pyramid.h"
#include "db/run/detail/tables.h"

namespace soak::db::run {

struct OpenedRunFile {
  sqlite::Connection connection;
  bool sealed = false;
};

/// Opens a run file for reading in the way that leaves it and its folder unchanged.
[[nodiscard]] base::Result<OpenedRunFile> open_run_file(const std::filesystem::path& path);

/// Opens a file that is not sealed and that nobody else has open, for writing; nobody else can open it meanwhile.
/// Nothing where it is sealed.
[[nodiscard]] base::Result<std::optional<sqlite::Connection>> open_abandoned(const std::filesystem::path& path);

/// A stream that is being written, with its rows from the last full chunk on.
struct OpenStream {
  StoredStream stored;
  std::vector<Column> pending;          ///< one per channel
  std::uint64_t pending_first_row = 0;  ///< a multiple of kChunkRows
  std::size_t flushed = 0;              ///< pending rows that are stored already, in short chunks
  std::optional<double> last_t_s;
  std::vector<PyramidBuilder> pyramids;  ///< one per channel; have seen the rows before the pending ones

  [[nodiscard]] std::size_t pending_rows() const { return pending.front().rows(); }
};

/// A stream without rows.
[[nodiscard]] OpenStream new_stream(StoredStream stored);

/// The stream as its writer had it after the last flush.
[[nodiscard]] base::Result<OpenStream> restored_stream(const sqlite::Connection& connection,
                                                       codec::ColumnDecoder& decoder, StoredStream stored);

}  // namespace soak::db::run
