// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include "base/result.h"
#include "station/import/columns_map.h"
#include "station/import/source_recording.h"

namespace soak::station {

/// How to read a recording from a CSV file.
struct CsvOptions {
  ColumnsMap map;
  bool skip_bad = false;  ///< leave bad rows out and list them, instead of refusing the file
  /// Called now and then with the share of the file that is read (0..1); returning false stops the reading.
  std::function<bool(double)> progress;
};

/// Reads and checks a whole recording (docs/csv-format.md says what is accepted). Every refusal names file, line,
/// column and what would be right. Without `run` column the label is the file's stem.
[[nodiscard]] base::Result<SourceRecording> read_csv_recording(const std::filesystem::path& path,
                                                               const CsvOptions& options);

/// The same from text in memory; `path` names it in messages.
[[nodiscard]] base::Result<SourceRecording> parse_csv_recording(std::string_view text,
                                                                const std::filesystem::path& path,
                                                                const CsvOptions& options);

}  // namespace soak::station
