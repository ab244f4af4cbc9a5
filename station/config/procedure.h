// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/unit_type.h"

namespace soak::station {

/// What the runs of a procedure are for. A fit takes those for calibration; a verification takes those for it.
enum class Purpose : std::uint8_t { calibration, verification, diagnosis };

/// `soak`: plateaus, six positions at each. `ramp`: one sweep without plateaus in one position. `rest`: one
/// temperature, one position.
enum class ProcedureKind : std::uint8_t { soak, ramp, rest };

/// How the order of the positions changes from run to run; + and − of an axis stay adjacent.
enum class PositionChange : std::uint8_t { same, reverse, rotate, rotate_and_reverse };

/// What is done when a unit's temperature does not become stable in time.
enum class TimeoutOutcome : std::uint8_t {
  skip_plateau,  ///< go on with the next set point; positions that were recorded there stay
  record,        ///< record all the same, with an event that says so
  abort,         ///< end the campaign safely
};

/// What `soak campaign resume` does with a run that was cut short.
enum class BreakOutcome : std::uint8_t {
  resume,      ///< what was recorded is kept; the rest is recorded from one plateau before the break on
  repeat_run,  ///< what was recorded is voided; the run begins again
};

/// What a new soakd does with a campaign that its predecessor did not end, once the chamber is safe.
enum class RestartOutcome : std::uint8_t {
  wait,    ///< for `soak campaign resume`
  resume,  ///< goes on with it
};

/// When a unit counts as settled (calib/judge/stability.h).
struct StabilitySettings {
  double slope_kpmin = 0.02;      ///< limit of |slope| plus its confidence half-width
  double confidence = 0.999;      ///< of one look; a wait looks many times
  double window_s = 300.0;        ///< longest stretch that a slope is taken from
  double min_window_s = 120.0;    ///< shortest
  double minimum_soak_s = 600.0;  ///< since the set point was reached by the air
  double after_turn_s = 30.0;     ///< shortest stretch after a turn
  double timeout_s = 7200.0;
  TimeoutOutcome on_timeout = TimeoutOutcome::skip_plateau;
};

/// Everything that a procedure file says. Times are process time, seconds.
struct Procedure {
  std::string name;
  std::string description;
  std::string file;
  Purpose purpose = Purpose::calibration;
  ProcedureKind kind = ProcedureKind::soak;
  int runs = 1;
  BreakOutcome on_break = BreakOutcome::resume;
  RestartOutcome on_restart = RestartOutcome::wait;
  double give_up_h = 12.0;                ///< process time of the longest suspension; then the campaign ends safely
  std::vector<double> set_points_c;       ///< of one run, in order, each a visit; reference plateaus included
  std::optional<double> reference_c;      ///< where each run begins and ends, so that runs can be compared
  std::optional<double> ramp_rate_kpmin;  ///< asked of the controller; absent = as fast as it can
  double overshoot_c = 2.0;               ///< by which the air may pass a set point: counted against ratings
  std::vector<std::string> positions;     ///< fixture positions in the order of the first run
  PositionChange position_change = PositionChange::rotate_and_reverse;
  double turned_deg = 0.0;  ///< of the whole fixture about the vertical, clockwise seen from above, while it runs
  double dwell_s = 600.0;   ///< recorded in each position
  std::vector<std::string> rate_positions;  ///< in which each visit ends with turning at each of `rates_dps`
  std::vector<double> rates_dps;            ///< about the vertical, counter-clockwise seen from above
  double rate_dwell_s = 60.0;               ///< recorded at each rate
  double segment_change_c = 0.1;            ///< a segment in which a unit's temperature moved more is repeated
  int segment_attempts = 3;                 ///< before the last one is kept and marked
  StabilitySettings stability;
  double rate_hz = 100.0;  ///< asked of the units
  double temp_rate_hz = 10.0;
  double power_off_s = 60.0;            ///< between runs
  double warm_up_s = 0.0;               ///< after power-on, before anything else
  std::optional<int> cycle_at_visit;    ///< after it units go off and on: a run ends and another begins there
  int cycles = 1;                       ///< how often, one after the other; each time the visit is repeated
  double preflight_position_s = 100.0;  ///< six of them; 0 = no pre-flight
  double end_c = 25.0;                  ///< where a run ends; at least 25
  double estimate_rate_kpmin = 2.0;     ///< for the estimate of hours: how fast this lab's chamber changes
  double estimate_settle_s = 1500.0;    ///< ... and how long a plateau takes to settle after the ramp
};

/// Reads a procedure. All mistakes at once, one per line of the message, each with "`file`:line" (a syntax error: the
/// first one): unknown or missing keys, wrong types, values out of their limits, a position twice, set points that
/// leave the rating of one of `types` (rating_check.h)...
[[nodiscard]] base::Result<Procedure> parse_procedure(std::string_view text, const std::string& file,
                                                      const std::vector<calib::UnitType>& types = {});
[[nodiscard]] base::Result<Procedure> read_procedure(const std::filesystem::path& file,
                                                     const std::vector<calib::UnitType>& types = {});

/// What is wrong with a procedure whose set points, overshoot included, leave the rating of any of the unit types: one
/// text per type, with its rating and the first set point that leaves it. The temperature at which a run ends is a set
/// point too. A type without a rating is a finding: nobody knows what it bears.
[[nodiscard]] std::vector<std::string> rating_findings(const Procedure& procedure,
                                                       const std::vector<calib::UnitType>& types);

/// Refuses (bad_input) a procedure with such findings, and one whose set points leave the chamber's own limits. One
/// finding per line.
[[nodiscard]] base::Status check_ratings(const Procedure& procedure, const std::vector<calib::UnitType>& types,
                                         std::optional<double> chamber_min_c, std::optional<double> chamber_max_c);

[[nodiscard]] std::string_view name_of(Purpose purpose);
[[nodiscard]] std::string_view name_of(ProcedureKind kind);

}  // namespace soak::station
