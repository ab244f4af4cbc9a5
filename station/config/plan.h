// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/run.h"
#include "station/config/procedure.h"

namespace soak::station {

enum class StepKind : std::uint8_t {
  turn_fixture,     ///< the operator turns the whole fixture about the vertical to `heading_deg`
  power_on,         ///< opens the run's file; switches the units on; each proves that it restarted and who it is
  move,             ///< turns the fixture to `position`; the units' accelerometers prove it
  spin,             ///< turns it at `rate_dps` in `position`, the units' gyros prove it; at 0 it is halted
  set_temperature,  ///< gives the set point `temp_c` and waits until the air is there
  wait_stable,      ///< until every unit is settled, at most `seconds`
  record,           ///< `seconds` of samples in `position` at plateau `temp_c`
  check,            ///< pre-flight: judges what was recorded; a finding ends the campaign
  warm_end,         ///< drives to `temp_c` until no unit can gather dew, then the chamber off
  power_off,        ///< seals the run's file and enters it into the catalog; units off for `seconds` at least
};

/// One thing to do. Data: nothing here touches a device.
struct Step {
  StepKind kind = StepKind::power_on;
  int run = 0;     ///< index into Plan::runs
  int visit = -1;  ///< ordinal of the plateau in the run, -1 = none
  double temp_c = 0.0;
  calib::Sweep sweep = calib::Sweep::unknown;
  std::string position;      ///< fixture position
  double heading_deg = 0.0;  ///< turn_fixture: against the usual heading, clockwise seen from above
  double rate_dps = 0.0;     ///< spin, record: of the fixture about the vertical, counter-clockwise seen from above
  double seconds = 0.0;
  bool after_turn = false;  ///< wait_stable: the short check after a turn
  double estimate_s = 0.0;  ///< expected process time
};

/// One power-on to power-off pass.
struct PlannedRun {
  std::string label;  ///< R01, R02...; P00 = pre-flight
  bool preflight = false;
  std::size_t first_step = 0;
  std::size_t last_step = 0;
};

/// What a procedure becomes: the only thing that check, estimate, engine and journal read.
struct Plan {
  Procedure procedure;
  std::vector<PlannedRun> runs;
  std::vector<Step> steps;

  [[nodiscard]] double estimate_s() const;
  /// From step `index` (not yet begun) to the end.
  [[nodiscard]] double remaining_s(std::size_t index) const;
};

/// The order of the positions in run number `run` (from 0). What turns and reverses are the axes, so that + and − of
/// one stay side by side. `rotate`: each run begins one axis later. `reverse`: every other run goes backwards.
/// `rotate_and_reverse`: both, backwards in every other run and one axis later after each pair: with three axes, six
/// runs have six orders.
[[nodiscard]] std::vector<std::string> positions_of_run(const Procedure& procedure, int run);

/// Compiles a procedure; never fails for one that parse_procedure() made. `room_c`: where a run's first ramp starts.
[[nodiscard]] Plan compile_plan(const Procedure& procedure, double room_c = 25.0);

/// One line for the operator: "R02 visit 5, +35 °C up: record 60 s at +X".
[[nodiscard]] std::string describe(const Plan& plan, std::size_t step);

[[nodiscard]] std::string_view name_of(StepKind kind);

/// The plan as it stands in the journal and in `/api/v1/plan`.
[[nodiscard]] nlohmann::json plan_document(const Plan& plan);

/// The same document as the station's page asks for it, since a plan of twenty runs has over a megabyte of steps: of
/// them only those of the plateau that step number `step` belongs to, or between two plateaus; docs/http-api.md.
/// Refuses (bad_input, at "around") a step that the plan does not have.
[[nodiscard]] base::Result<nlohmann::json> plan_around(const nlohmann::json& document, std::int64_t step);

}  // namespace soak::station
