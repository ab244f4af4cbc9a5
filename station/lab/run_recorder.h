// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/run.h"
#include "db/catalog/catalog.h"
#include "db/run/run_file.h"
#include "hal/devices/chamber.h"
#include "hal/devices/unit_power.h"
#include "hal/imu/imu.h"
#include "station/lab/campaign_log.h"
#include "station/runs/run_columns.h"
#include "station/runs/run_records.h"

namespace soak::station {

/// What the run files that soakd records state as their source.
inline constexpr std::string_view kRunSource = "soakd";

/// A segment that shall not be used. It is withdrawn by a void record, never left out of the file.
struct Rejected {
  std::string unit;      ///< serial number
  int visit = 0;         ///< as in RowLabels; -1 where neither the labels nor a plateau give one
  std::string position;  ///< where the fixture turns, with the rate: label_at_rate()
  int attempt = 0;  ///< how many attempts the unit has in that position of that visit before, see RunRecorder::add()
  std::string reason;
};

/// Records one run: the open run file of all its units, and at the end their rows in the catalog. One thread at a time.
/// Destroyed without finish(), it leaves an unsealed file with everything that was flushed (orphan_run_files() finds
/// it).
class RunRecorder {
 public:
  /// Creates runs/<run id>.soakrun and enters units that are new into the catalog: their types are known now, while
  /// whoever finds the file of a killed soakd knows serial numbers only. `purpose` as in db::RunRow; it takes the place
  /// of that in `info`. `with_rates`: rows may be of a fixture that turns. Refuses no units, a serial number that
  /// stands twice, and a run whose campaign holds its label already for one of them (bad_input).
  [[nodiscard]] static base::Result<RunRecorder> begin(db::Catalog& catalog, const db::RunInfo& info,
                                                       std::string purpose, std::vector<RecordedUnit> units,
                                                       bool with_rates = false);
  RunRecorder(RunRecorder&&) noexcept;
  RunRecorder& operator=(RunRecorder&&) noexcept;
  ~RunRecorder();

  /// Appends samples of unit number `unit`, oldest first, with the device's own numbers.
  ///
  /// An attempt is a stretch of soak rows of one visit and one position without any other row between: each becomes a
  /// segment of its own. One row is enough to separate two attempts, be it of phase ramp with visit and position as
  /// before (the same position once more) or without a position (the unit was turned). Attempts count from 0 within
  /// unit, visit and position.
  ///
  /// Refuses (bad_input) a time that does not rise and a position that is none of the six; then no row is taken. After
  /// another error (disk full) the rows are kept in memory: they must not be added again.
  [[nodiscard]] base::Status add(std::size_t unit, std::span<const hal::ImuSample> samples, const RowLabels& labels);
  /// Appends to the chamber's log and to the next row of each unit. `t_s` is device time of one of the units; where it
  /// falls, the last one stands.
  [[nodiscard]] base::Status add_chamber(double t_s, const hal::ChamberReading& reading);
  /// What the output that feeds unit number `unit` delivers: goes into the unit's next row. The unit must be one whose
  /// supply is measured.
  void add_supply(std::size_t unit, const hal::OutputReading& reading);
  [[nodiscard]] base::Status add_event(double t_s, std::string_view kind, std::string_view text);
  /// Commits what was added: it survives a loss of power. To be called every few seconds.
  [[nodiscard]] base::Status flush();
  /// Ends the run: seals the file, enters one row per unit with its segments into the catalog, and withdraws the
  /// segments of rejected attempts (user "soakd"), all or nothing. A unit without rows is left out, with an event in
  /// the file. A rejection without a segment (the unit gave no usable rows there) is logged. Where it fails it may be
  /// called again. Reads the whole file: seconds to minutes.
  /// In the same transaction `void_reason` withdraws the whole run, `void_units` (serial number → why) parts of it.
  [[nodiscard]] base::Result<std::vector<db::RunRow>> finish(const std::vector<Rejected>& rejected,
                                                             const std::optional<std::string>& void_reason = {},
                                                             const std::map<std::string, std::string>& void_units = {});

  [[nodiscard]] const db::RunInfo& info() const;
  /// Rows of unit number `unit` so far.
  [[nodiscard]] std::uint64_t rows(std::size_t unit) const;

 private:
  struct Impl;
  explicit RunRecorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Seals the run files that a killed soakd left open and enters them into the catalog, voided, with every row that was
/// flushed: nothing that was recorded is lost, and no fit takes half a run unasked. The same is done with files
/// that were sealed but not entered. A file that cannot be read is logged and left as it is; one without samples is
/// sealed, and stays outside the catalog.
[[nodiscard]] base::Status enter_lost_runs(db::Catalog& catalog, EventLog& log);

/// What recording writes to the disk, on the safe side: run files compress, catalog and temporary files do not.
[[nodiscard]] double estimated_bytes(double rate_hz, std::size_t units, double seconds);

}  // namespace soak::station
