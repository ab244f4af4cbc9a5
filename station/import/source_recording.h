// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/position.h"
#include "db/run/sample.h"
#include "hal/imu/imu.h"
#include "station/import/columns_map.h"

namespace soak::station {

/// A row that was skipped.
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

/// How to read a recording from a CSV file.
struct CsvOptions {
  ColumnsMap map;
  bool skip_bad = false;  ///< skip bad rows and list them, instead of failing
  /// Called now and then with the share of the file that is read (0..1); returning false stops the reading.
  std::function<bool(double)> progress;
};

/// Reads and checks a whole recording (docs/csv-format.md says what is accepted). Every error names file, line,
/// column and what would be right. Without `run` column the label is the file's stem.
[[nodiscard]] base::Result<SourceRecording> read_csv_recording(const std::filesystem::path& path,
                                                               const CsvOptions& options);

/// The same from text in memory; `path` names it in messages.
[[nodiscard]] base::Result<SourceRecording> parse_csv_recording(std::string_view text,
                                                                const std::filesystem::path& path,
                                                                const CsvOptions& options);

/// How to read the bytes that a unit once sent.
struct StreamOptions {
  hal::UnitDecoder decoder = hal::UnitDecoder::xsens;
  hal::Ahrs400Ranges ranges = {};  ///< for ahrs400 only
  double rate_hz = 100.0;          ///< that the unit was set to: lost packets are told from a restart by it
  /// Called now and then with the share of the file that is read (0..1); returning false stops the reading.
  std::function<bool(double)> progress;
};

/// Decodes a file of bytes as a unit has sent them (a vendor's log, a capture of its serial line): one run per
/// power-on, called as the file's stem, with a number behind it where there are several. Each run is one attitude
/// throughout, as a CSV file without positions. Packets lost by the unit's own counter, and bytes that belong to no
/// packet, are warnings. Refuses (bad_input) a file in which nothing can be decoded, and a run without any temperature.
[[nodiscard]] base::Result<SourceRecording> read_stream_recording(const std::filesystem::path& path,
                                                                  const StreamOptions& options);

}  // namespace soak::station
