// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "db/detail/column_codec.h"
#include "db/detail/connection.h"
#include "db/run/detail/tables.h"

/// Passes over all samples of a run file.
namespace soak::db::run {

/// See RunFileReader::content_hash().
[[nodiscard]] base::Result<std::string> content_hash_of(const sqlite::Connection& connection,
                                                        codec::ColumnDecoder& decoder,
                                                        const std::vector<StoredStream>& streams);

/// Every chunk's checksum, the row counts, the order of time, and the pyramid against the samples. `finished`: the
/// pyramid covers all rows; otherwise it covers full chunks.
[[nodiscard]] base::Status check_samples(const sqlite::Connection& connection, codec::ColumnDecoder& decoder,
                                         const std::vector<StoredStream>& streams, bool finished);

}  // namespace soak::db::run
