// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "hal/devices/fixture.h"
#include "hal/devices/unit_power.h"
#include "station/config/plan.h"
#include "station/config/station_config.h"
#include "station/lab/campaign_log.h"
#include "station/lab/device_monitors.h"
#include "station/lab/run_recorder.h"
#include "station/lab/run_sealer.h"
#include "station/lab/segment_capture.h"
#include "station/lab/unit_channel.h"

namespace soak::station {

/// The campaign that is carried out.
struct Campaign {
  std::string name;
  std::string begun_by;  ///< begun_by()
  Plan plan;
  std::vector<std::string> missing_units = {};  ///< which units are missing from which run
  bool purge_confirmed = false;                 ///< the operator has confirmed that dry air flows
};

/// What the steps of a campaign work on: devices, units, the open run file. Belongs to the engine's thread.
class Station {
 public:
  Station(const StationConfig& config, db::Catalog& catalog, EventLog& log, hal::Chamber& chamber,
          hal::Fixture* fixture, hal::UnitPower* power);

  const StationConfig& config;
  db::Catalog& catalog;
  EventLog& log;
  ProcessTime time;
  ChamberMonitor chamber;
  hal::Fixture* const fixture;       ///< null = turned by hand
  std::optional<UnitSupply> supply;  ///< nothing = switched by hand
  Prompts prompts;
  Campaign campaign;
  std::vector<std::unique_ptr<UnitChannel>> units;
  std::vector<PreflightRecord> preflight;
  RunSealer sealer;

  [[nodiscard]] double now_s() const { return time.now_s(); }
  [[nodiscard]] const Procedure& procedure() const { return campaign.plan.procedure; }
  /// The units that take part in the present run.
  [[nodiscard]] std::vector<UnitChannel*> active_units() const;
  [[nodiscard]] bool simulated() const;

  /// Reads where the fixture is.
  [[nodiscard]] base::Result<hal::FixtureReading> read_fixture();
  /// What the fixture reported last; nothing where it did not answer.
  [[nodiscard]] const std::optional<hal::FixtureReading>& fixture_reading() const { return fixture_reading_; }

  /// Ends a turning at a rate, where there is one.
  [[nodiscard]] base::Status halt_fixture();

  /// Reads units and chamber, advances the time, writes to the run file, drops units that have stopped sending. An
  /// error is one of storage: nothing more can be recorded.
  [[nodiscard]] base::Status poll();

  /// From now on samples are kept for the run file that is about to be opened; while a prompt is open, the last ones.
  void expect_run();
  /// Forgets them: however long it takes until the run can begin, nothing piles up.
  void expect_no_run();
  [[nodiscard]] base::Status begin_run(const PlannedRun& run);
  /// Seals the run file and enters it into the catalog beside the engine's thread: to be called until it says true, or
  /// why it failed; then it may be called again. `why_cut`: the run was cut short. With on_break = "resume" its
  /// complete segments are kept, unless it was `aborted`; else it is voided. A run that is being sealed already is
  /// waited for: its end is known.
  [[nodiscard]] base::Result<bool> end_run(const std::optional<std::string>& why_cut, bool aborted = false);
  /// Enters what killed predecessors left behind, beside the engine's thread: to be called until it says true, or why
  /// it failed. Runs of the campaign that was aborted are voided.
  [[nodiscard]] base::Result<bool> enter_left_runs(const std::string& aborted_campaign = {});
  /// Commits what was recorded: a step whose end the journal knows must not lose its rows.
  [[nodiscard]] base::Status flush();
  /// While it is held nothing is recorded: the disk has no room for it.
  void hold_recording(bool held) { recording_is_held_ = held; }
  /// Leaves a run file that cannot be sealed: everything that was flushed stays in it (enter_lost_runs()).
  void leave_run() {
    recorder_.reset();
    seal_trouble_.clear();
    sealer.leave();
  }
  /// Whether rows are recorded; no more once end_run() was called.
  [[nodiscard]] bool run_is_open() const { return recorder_.has_value(); }
  /// Why the run could not be sealed so far; empty where none waits for that.
  [[nodiscard]] const std::string& seal_trouble() const { return seal_trouble_; }
  /// Of the run that is open or being sealed.
  [[nodiscard]] std::string run_id() const { return recorder_ ? recorder_->info().run_id : sealer.run_id(); }

  /// Drops a unit for the rest of the run: it is no longer waited for, and its part of the run ends there.
  void lose(UnitChannel& unit, const std::string& why);
  /// Switches off the output of a unit whose supply has a fault.
  void cut_off(const UnitChannel& unit);

  /// Rows from now on belong to this set point; without one they are on the way.
  void set_plateau(std::optional<double> plateau_c, calib::Sweep sweep, int visit);
  /// `rate_dps`: at which the fixture turns while it is not moving elsewhere.
  void set_moving(bool moving, double rate_dps = 0.0) {
    moving_ = moving;
    labels_.rate_dps = rate_dps;
  }
  /// Begins to capture a segment from every active unit.
  void begin_segment(double seconds);
  /// Ends the captures. `why_not`, where given for a unit, rejects its segment.
  void end_segment(const std::map<std::string, std::string>& why_not);
  /// Ends captures that are not complete: what was recorded so far is rejected.
  void break_segment(const std::string& reason);
  /// Withdraws what the open run holds of a visit that begins again. A unit that is no longer measured keeps its part.
  void withdraw_visit(int visit, const std::string& reason);

 private:
  /// The unit's clock on process time; nothing where it does not stream.
  std::optional<double> poll_unit(UnitChannel& unit);
  [[nodiscard]] base::Status record(UnitChannel& unit);
  void buffer_samples(const UnitChannel& unit);
  [[nodiscard]] base::Status add_rows(UnitChannel& unit, std::span<const hal::ImuSample> samples);
  void close_capture(UnitChannel& unit, const std::optional<std::string>& why_not);
  [[nodiscard]] base::Status record_chamber();
  void find_silent_units();
  /// The unit's position, with the rate where the fixture turns.
  [[nodiscard]] std::string position_label(const UnitChannel& unit) const;
  void watch_supply();
  void judge_supply(UnitChannel& unit);
  [[nodiscard]] base::Status open_recorder(const PlannedRun& run);
  [[nodiscard]] RunEnd end_of_run(const std::optional<std::string>& why_cut, bool aborted) const;
  /// True once the sealer has nothing more to do for the run, or why that failed.
  [[nodiscard]] base::Result<bool> follow_sealing();
  [[nodiscard]] std::string free_label(const std::string& label) const;
  [[nodiscard]] std::string part_before(const std::string& label) const;

  std::optional<RunRecorder> recorder_;
  std::optional<hal::FixtureReading> fixture_reading_;
  bool recording_is_held_ = false;
  std::string seal_trouble_;
  bool expecting_run_ = false;
  bool run_is_preflight_ = false;  ///< the run that is open or being sealed
  std::map<std::string, std::vector<hal::ImuSample>>
      samples_before_run_;                             ///< serial → samples before the file was there
  std::map<std::string, std::uint32_t> run_power_on_;  ///< serial → power-on that the run belongs to
  RowLabels labels_;
  bool moving_ = true;
  std::map<std::string, std::string> lost_;  ///< units of the open run: serial → why
  std::chrono::steady_clock::time_point flushed_{};
};

}  // namespace soak::station
