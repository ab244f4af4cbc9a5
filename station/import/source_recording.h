// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/vocabulary/position.h"
#include "db/run/sample.h"

namespace soak::station {

/// A row that was left out.
struct BadRow {
  std::size_t line = 0;
  std::string column;  ///< header cell; empty where the row as a whole is wrong
  std::string reason;
};

/// The rows of one run, in the source's own numbers. The first channel is `t_s`.
struct SourceRun {
  std::string label;
  std::size_t first_line = 0;
  std::vector<db::ChannelInfo> channels;
  std::vector<db::Column> columns;
  std::vector<calib::Position> positions;  ///< of the map, those that occur in this run, labels as they are spelt there

  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : columns.front().rows(); }
};

/// All runs of a file that was recorded elsewhere, before they are stored.
struct SourceRecording {
  std::vector<SourceRun> runs;
  std::vector<BadRow> bad_rows;
  std::vector<std::string> warnings;
};

}  // namespace soak::station
