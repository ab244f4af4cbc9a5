// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
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

/// How a run ends.
struct RunEnd {
  std::optional<std::string> void_reason = {};         ///< withdraws the whole run
  std::map<std::string, std::string> void_units = {};  ///< serial number → why: withdraws parts of it
  bool keeps_parts = false;                            ///< only what has no complete segment (SealedRun::keeps_parts)
};

/// Records one run: the open run file of all its units, and at the end their rows in the catalog. One thread at a time.
/// Destroyed without finish(), it leaves an unsealed file with everything that was flushed (orphan_run_files() finds
/// it).
class RunRecorder {
 public:
  /// Creates runs/<run id>.soakrun and enters units that are new into the catalog: their types are known now, while
  /// whoever finds the file of a killed soakd knows serial numbers only. `purpose` as in db::RunRow; it takes the place
  /// of that in `info`. `with_rates`: rows may be of a fixture that turns. Refuses no units, a serial number that
  /// is duplicated, and a run whose campaign holds its label already for one of them (bad_input).
  [[nodiscard]] static base::Result<RunRecorder> begin(db::Catalog& catalog, const db::RunInfo& info,
                                                       std::string purpose, std::vector<RecordedUnit> units,
                                                       bool with_rates = false);
  /// Appends samples of unit number `unit`, oldest first, with the device's own numbers.
  ///
  /// An attempt is a stretch of soak rows of one visit and one position without any other row between: each becomes a
  /// segment of its own. One row is enough to separate two attempts, be it of phase ramp with visit and position as
  /// before (the same position once more) or without a position (the unit was turned).
  ///
  /// Packets that the unit's counter shows lost (ImuSample::lost) become an event (PacketLoss), and enter_run() marks
  /// the segments that it touches.
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
  /// The last attempt of unit number `unit` shall not be used. Its rows stay in the file; finish() withdraws the
  /// segment.
  void reject(std::size_t unit, std::string reason);
  /// The last attempt of unit number `unit` is complete. Like a rejection it stands in the file, so that whoever finds
  /// the file of a killed soakd knows which segments count.
  void accept(std::size_t unit);
  /// What was accepted of unit number `unit` at this visit shall not be used: the visit begins again. Returns how many
  /// attempts that are.
  std::size_t withdraw_visit(std::size_t unit, int visit, const std::string& reason);
  /// Rejections so far.
  [[nodiscard]] std::size_t rejected() const { return sealed_.withdrawals.size(); }
  /// Ends the run: seals the file, enters one row per unit with its segments into the catalog, and withdraws the
  /// segments of rejected attempts (user "soakd"), all or nothing. A unit without rows is left out, with an event in
  /// the file. A rejection without a segment (the unit gave no usable rows there) is logged. Where it fails it may be
  /// called again. Reads the whole file: seconds to minutes. `catalog` may be another connection than that of begin():
  /// with it the recorder may have gone to another thread (RunSealer).
  [[nodiscard]] base::Result<std::vector<db::RunRow>> finish(db::Catalog& catalog, const RunEnd& end);
  /// The same over the connection of begin().
  [[nodiscard]] base::Result<std::vector<db::RunRow>> finish(const std::optional<std::string>& void_reason = {},
                                                             const std::map<std::string, std::string>& void_units = {},
                                                             bool keeps_parts = false) {
    return finish(*catalog_, {void_reason, void_units, keeps_parts});
  }

  [[nodiscard]] const db::RunInfo& info() const { return info_; }
  /// Rows of unit number `unit` so far.
  [[nodiscard]] std::uint64_t rows(std::size_t unit) const { return units_.at(unit).rows; }

 private:
  static constexpr double kNever_s = -std::numeric_limits<double>::infinity();

  /// One recording of a position: what a segment will be made of.
  struct Attempt {
    std::optional<int> visit;
    std::string position;
    double from_s = 0.0;
    double to_s = 0.0;
  };
  /// One that counts.
  struct Accepted {
    std::size_t unit = 0;
    Attempt attempt;
  };
  /// What is known of one unit's rows so far.
  struct UnitStream {
    RecordedUnit unit;
    std::size_t stream = 0;
    std::optional<std::size_t> position_stream = {};  ///< where azimuths are known
    std::set<std::string> placed = {};                ///< labels of the rows in it
    std::uint64_t rows = 0;
    double last_t_s = kNever_s;
    SlowReadings fresh = {};  ///< for the next row
    int counted_visit = -1;   ///< where the labels do not number the visits
    std::optional<double> last_plateau_c = {};
    bool recording = false;  ///< the last row belongs to the last attempt
    std::optional<Attempt> attempt = {};
    PacketLoss loss = {};  ///< that no event tells of yet

    /// Visit of the rows with these labels; nothing outside plateaus.
    std::optional<int> visit_of(const RowLabels& labels);
    void follow_attempt(const RowLabels& labels, std::optional<int> visit, double from_s, double to_s);
    [[nodiscard]] base::Status check(std::span<const hal::ImuSample> samples, const RowLabels& labels) const;
  };
  RunRecorder(db::Catalog& catalog, db::RunFileWriter file, db::RunInfo info, bool with_rates)
      : catalog_(&catalog), file_(std::move(file)), info_(std::move(info)), with_rates_(with_rates) {}
  [[nodiscard]] base::Status add_streams(const std::vector<RecordedUnit>& units);
  [[nodiscard]] base::Status note_losses(UnitStream& unit, std::span<const hal::ImuSample> samples, bool same_stretch);
  [[nodiscard]] base::Status write_loss(UnitStream& unit);
  [[nodiscard]] base::Status note_position(UnitStream& unit, const std::string& label, double t_s);
  [[nodiscard]] base::Status seal(const RunEnd& end);
  [[nodiscard]] base::Status note_end(double t_s, const RunEnd& end);
  /// Withdraws an attempt, in the file and for finish().
  void withdraw(const UnitStream& rows, const std::optional<Attempt>& attempt, std::string reason);

  db::Catalog* catalog_;
  db::RunFileWriter file_;
  db::RunInfo info_;
  SealedRun sealed_;  ///< `sha256` is empty while the file is open
  bool with_rates_;
  bool noted_end_ = false;  ///< the events of its end are in the file
  std::vector<UnitStream> units_;
  std::vector<Accepted> accepted_;
  std::size_t chamber_stream_ = 0;
  double last_chamber_t_s_ = kNever_s;
};

/// A run file that was left behind, and what became of it.
struct LostRun {
  std::string label;
  std::string text;
};

/// Seals the run files that a killed soakd left open and enters them into the catalog with every row that was flushed,
/// cut short: rejected segments and one that was under way are withdrawn. Voided are a pre-flight, a run without a
/// complete segment, one of the campaign that was aborted, and one whose procedure says on_break = "repeat_run". The
/// same is done with files that were sealed but not entered, or whose entry is gone with a catalog that was restored:
/// one that says how its run ended is entered as that says. A file that cannot be read is told of and left as it is;
/// one without samples is sealed, and stays outside the catalog.
[[nodiscard]] base::Result<std::vector<LostRun>> enter_lost_runs(db::Catalog& catalog,
                                                                 const std::string& aborted_campaign);
/// The same, told to the log.
[[nodiscard]] base::Status enter_lost_runs(db::Catalog& catalog, EventLog& log);

/// What recording writes to the disk, on the safe side: run files compress, catalog and temporary files do not.
[[nodiscard]] double estimated_bytes(double rate_hz, std::size_t units, double seconds);

}  // namespace soak::station
