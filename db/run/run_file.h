// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/run.h"
#include "db/run/sample.h"

namespace soak::db {

/// What a run file says of itself.
struct RunInfo {
  std::string run_id;  ///< UUIDv7
  std::string label;   ///< text of the `run` column or the file stem, verbatim
  std::string campaign;
  std::string procedure;
  std::string purpose = "calibration";  ///< as in RunRow; what a file without a purpose means
  double created_utc_s = 0.0;
  double clock_rate = 1.0;
  bool simulated = false;
  std::string continues = {};  ///< run id of the run that was cut short and goes on here; empty = none
  std::string source;          ///< where the samples came from: "import <file name>", device names...
  calib::Site site;
};

/// A table of samples on one time axis: the stream of one unit, or the chamber's log.
struct StreamInfo {
  std::string name;                   ///< "imu", "chamber"
  std::string unit;                   ///< serial number; empty for streams of no unit
  std::vector<ChannelInfo> channels;  ///< the first is the time axis `t_s`
};

/// Something that happened during the run.
struct RunEvent {
  double t_s = 0.0;
  std::string kind;
  std::string text;
};

/// One bin of the multi-resolution pyramid of a channel, in the channel's unit (scale and offset applied). Values that
/// are not finite count as absent; a bin without any value does not exist.
struct PyramidBin {
  double t_first_s = 0.0;
  double t_last_s = 0.0;
  std::uint64_t count = 0;  ///< present, finite values
  double minimum = 0.0;
  double mean = 0.0;
  double maximum = 0.0;
};

/// Rows of a stream that follow each other.
struct RowSpan {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

/// Writes one run file (application id 0x534F414B, "SOAK"; docs/file-formats.md). The file is in WAL mode while open;
/// seal() ends it. Destroyed without seal(), it leaves a readable, unsealed file with everything that was flushed. One
/// thread at a time. After a failed write (full disk...) the rows stay in memory: the next call tries again.
class RunFileWriter {
 public:
  /// Creates the file; refuses a path that exists. Leaves no file behind if it fails.
  [[nodiscard]] static base::Result<RunFileWriter> create(const std::filesystem::path& path, const RunInfo& info);
  /// Ends a file whose writer is gone (killed, power failed): adds the event "interrupted" with `text` at the time of
  /// the last row and seals it; everything that was flushed is in it. A file that was complete but for the last steps
  /// of sealing gets no event; a sealed one stays as it is. Reads all samples once. Returns the SHA-256 as seal() does.
  /// Refuses a file that another process or connection has open and one of another kind (bad_input), a damaged one
  /// (corrupt).
  [[nodiscard]] static base::Result<std::string> seal_interrupted(const std::filesystem::path& path,
                                                                  std::string_view text);
  RunFileWriter(RunFileWriter&&) noexcept;
  RunFileWriter& operator=(RunFileWriter&&) noexcept;
  ~RunFileWriter();

  /// Adds a stream; returns its index. Refuses a stream whose first channel is not `t_s`, a duplicated
  /// channel name, and a second stream of the same name and unit.
  [[nodiscard]] base::Result<std::size_t> add_stream(const StreamInfo& stream);
  /// Appends rows: one column per channel, in the channels' types, all of one length. The time axis has a finite value
  /// in every row and never falls. Takes all rows or, if it refuses them (bad_input), none.
  [[nodiscard]] base::Status append(std::size_t stream, const std::vector<Column>& columns);
  [[nodiscard]] base::Status add_event(double t_s, std::string_view kind, std::string_view text);
  /// Commits all rows and events so far (a short last chunk included). After success they survive a loss of power.
  [[nodiscard]] base::Status flush();
  /// Commits, completes the pyramid, checkpoints, leaves WAL mode, syncs; returns the SHA-256 of the file in
  /// hexadecimal. Fails while another connection has the file open, and may then be called again.
  [[nodiscard]] base::Result<std::string> seal();

 private:
  struct Impl;
  explicit RunFileWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Reads a run file, sealed or not, without changing it. A sealed file needs no more than read access to the file; one
/// that is not sealed needs a folder that can be written. One thread at a time.
class RunFileReader {
 public:
  /// Refuses a file of another kind or of a newer version (bad_input) and a damaged one (corrupt).
  [[nodiscard]] static base::Result<RunFileReader> open(const std::filesystem::path& path);
  RunFileReader(RunFileReader&&) noexcept;
  RunFileReader& operator=(RunFileReader&&) noexcept;
  ~RunFileReader();

  [[nodiscard]] const RunInfo& info() const;
  /// Whether seal() ended the file.
  [[nodiscard]] bool sealed() const;
  [[nodiscard]] const std::vector<StreamInfo>& streams() const;
  /// Rows that were flushed when the file was opened.
  [[nodiscard]] std::uint64_t rows(std::size_t stream) const;
  [[nodiscard]] base::Result<std::vector<RunEvent>> events() const;
  /// The rows whose time lies in [from_s, to_s], to the row. Reads some chunks of the time axis, however long the run.
  /// Refuses (bad_input) a span that ends before it starts.
  [[nodiscard]] base::Result<RowSpan> rows_between(std::size_t stream, double from_s, double to_s) const;
  /// `count` rows of one channel from `first_row` (fewer at the end). Checks the CRC of every chunk that it touches;
  /// corrupt, naming channel and chunk, where it fails. Absent rows hold zero bytes; `present` is empty if none is
  /// absent.
  [[nodiscard]] base::Result<Column> read(std::size_t stream, std::size_t channel, std::uint64_t first_row = 0,
                                          std::uint64_t count = UINT64_MAX) const;
  /// Rows of one channel in order, a chunk at a time: `take` is given their values as values_of() says, scale and
  /// offset of the channel applied. The memory of one chunk, used again. Fails as read() does; then `take` has been
  /// given the rows before.
  [[nodiscard]] base::Status scan(std::size_t stream, std::size_t channel,
                                  const std::function<void(std::span<const double>)>& take) const;
  /// At most about `max_bins` bins that cover [from_s, to_s]: the coarsest level of the pyramid that is fine enough,
  /// with adjacent bins joined; where no level is, bins made of the samples themselves.
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
