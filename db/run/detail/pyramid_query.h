// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "base/result.h"
#include "db/detail/column_codec.h"
#include "db/detail/connection.h"
#include "db/run/detail/tables.h"
#include "db/run/run_file.h"

namespace soak::db::run {

/// What a question to the pyramid is about.
struct PyramidSpan {
  double from_s = 0.0;
  double to_s = 0.0;
  std::size_t max_bins = 1;
};

/// See RunFileReader::pyramid(). `finished`: all levels cover all rows; otherwise each level covers what its complete
/// bins do, and smaller bins or samples stand in for the rest.
[[nodiscard]] base::Result<std::vector<PyramidBin>> query_pyramid(const sqlite::Connection& connection,
                                                                  codec::ColumnDecoder& decoder,
                                                                  const StoredStream& stream, std::size_t channel,
                                                                  bool finished, const PyramidSpan& span);

}  // namespace soak::db::run
