// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/run.h"
#include "db/sample.h"

namespace soak::db {

/// What a run file says of itself.
struct RunInfo {
  std::string run_id;  ///< UUIDv7
  std::string label;   ///< text of the `run` column or the file stem, verbatim
  std::string campaign;
  std::string procedure;
  double created_utc_s = 0.0;
  double clock_rate = 1.0;
  bool simulated = false;
  std::string source;  ///< where the samples came from: "import <file name>", device names...
  calib::Site site;
};

/// A table of samples on one time axis: the stream of one unit, or the chamber's log.
struct StreamInfo {
  std::string name;  ///< "imu", "chamber"
  std::string unit;  ///< serial number; empty for streams of no unit
  std::vector<ChannelInfo> channels;  ///< the first is the time axis `t_s`
};

/// One bin of the multi-resolution pyramid of a channel, in the channel's unit (scale and offset applied).
struct PyramidBin {
  double t_first_s = 0.0;
  double t_last_s = 0.0;
  std::uint64_t count = 0;  ///< present values
  double minimum = 0.0;
  double mean = 0.0;
  double maximum = 0.0;
};

/// Writes one run file (application id 0x534F414B, "SOAK"). The file is in WAL mode while open; seal() ends it.
/// Destroyed without seal(), it leaves a readable, unsealed file with everything that was flushed.
class RunFileWriter {
 public:
  /// Creates the file; refuses a path that exists.
  [[nodiscard]] static base::Result<RunFileWriter> create(const std::filesystem::path& path, const RunInfo& info);
  RunFileWriter(RunFileWriter&&) noexcept;
  RunFileWriter& operator=(RunFileWriter&&) noexcept;
  ~RunFileWriter();

  /// Adds a stream; returns its index. Refuses a stream whose first channel is not `t_s`.
  [[nodiscard]] base::Result<std::size_t> add_stream(const StreamInfo& stream);
  /// Appends rows: one column per channel, in the channels' types, all of one length.
  [[nodiscard]] base::Status append(std::size_t stream, const std::vector<Column>& columns);
  [[nodiscard]] base::Status add_event(double t_s, std::string_view kind, std::string_view text);
  /// Commits all rows so far (a short last chunk included).
  [[nodiscard]] base::Status flush();
  /// Commits, builds the pyramid, checkpoints, leaves WAL mode, syncs; returns the SHA-256 of the file in hexadecimal.
  [[nodiscard]] base::Result<std::string> seal();

 private:
  struct Impl;
  explicit RunFileWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Reads a run file, sealed or not, without changing it.
class RunFileReader {
 public:
  [[nodiscard]] static base::Result<RunFileReader> open(const std::filesystem::path& path);
  RunFileReader(RunFileReader&&) noexcept;
  RunFileReader& operator=(RunFileReader&&) noexcept;
  ~RunFileReader();

  [[nodiscard]] const RunInfo& info() const;
  [[nodiscard]] const std::vector<StreamInfo>& streams() const;
  [[nodiscard]] std::uint64_t rows(std::size_t stream) const;
  /// `count` rows of one channel from `first_row` (fewer at the end). Checks the CRC of every chunk that it touches.
  [[nodiscard]] base::Result<Column> read(std::size_t stream, std::size_t channel, std::uint64_t first_row = 0,
                                          std::uint64_t count = UINT64_MAX) const;
  /// At most about `max_bins` bins that cover [from_s, to_s]: the coarsest level of the pyramid that is fine enough.
  [[nodiscard]] base::Result<std::vector<PyramidBin>> pyramid(std::size_t stream, std::size_t channel, double from_s,
                                                              double to_s, std::size_t max_bins) const;
  /// SHA-256 over the streams' meaning (names, units, types, labels) and every number, independent of how the file is
  /// laid out and of run id, label and times: two files with equal content hash hold the same samples.
  [[nodiscard]] base::Result<std::string> content_hash() const;
  /// SQLite's integrity check, every chunk's CRC, row counts and the pyramid against the samples.
  [[nodiscard]] base::Status verify() const;

 private:
  struct Impl;
  explicit RunFileReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace soak::db
