// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/position.h"
#include "db/run_file.h"
#include "db/sample.h"
#include "station/columns_map.h"

namespace soak::station {

/// How to read a recording from a CSV file.
struct CsvOptions {
  ColumnsMap map;
  bool skip_bad = false;  ///< leave bad rows out and list them, instead of refusing the file
  /// Called now and then with the share of the file that is read (0..1); returning false stops the reading.
  std::function<bool(double)> progress;
};

/// A row that was left out.
struct BadRow {
  std::size_t line = 0;
  std::string column;  ///< header cell; empty where the row as a whole is wrong
  std::string reason;
};

/// The rows of one run, in the source's own numbers. The first channel is `t_s`.
struct CsvRun {
  std::string label;
  std::size_t first_line = 0;
  std::vector<db::ChannelInfo> channels;
  std::vector<db::Column> columns;
  std::vector<calib::Position> positions;  ///< of the map, those that occur in this run, labels as they are spelt there

  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : columns.front().rows(); }
};

/// All runs of a CSV file.
struct CsvRecording {
  std::vector<CsvRun> runs;
  std::vector<BadRow> bad_rows;
  std::vector<std::string> warnings;
};

/// Reads and checks a whole recording (docs/csv-format.md says what is accepted). Every refusal names file, line,
/// column and what would be right. Without `run` column the label is the file's stem.
[[nodiscard]] base::Result<CsvRecording> read_csv_recording(const std::filesystem::path& path,
                                                            const CsvOptions& options);

/// The same from text in memory; `path` names it in messages.
[[nodiscard]] base::Result<CsvRecording> parse_csv_recording(std::string_view text, const std::filesystem::path& path,
                                                             const CsvOptions& options);

}  // namespace soak::station
