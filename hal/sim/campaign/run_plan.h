// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "calib/vocabulary/position.h"
#include "calib/vocabulary/run.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/unit/attitude.h"

namespace soak::hal::sim {

/// One set point of a run, with the sweep that it belongs to. The start plateau opens the up sweep: the unit is powered
/// on when it has settled there. The turning plateau keeps its arrival direction.
struct SetPoint {
  double temp_c = 0.0;
  calib::Sweep sweep = calib::Sweep::unknown;

  bool operator==(const SetPoint&) const = default;
};

/// `start_c`, one step up at a time to `turn_c`, and down again to `start_c`.
[[nodiscard]] std::vector<SetPoint> campaign_set_points(const CampaignConfig& config);

/// The middles between the plateaus, up and down again: temperatures that no fit has seen.
[[nodiscard]] std::vector<SetPoint> verification_set_points(const CampaignConfig& config);

/// The six positions in the order of a run: rotated by one axis from each run to the next and reversed in every other
/// one (six different orders), + and − of an axis always adjacent.
[[nodiscard]] std::array<calib::Position, 6> position_order(int run);

/// Stay at a set point. Times are seconds since power-on.
struct Visit {
  SetPoint set_point;
  double t_change_s = 0.0;  ///< when the set point was given
  double t_soak_s = 0.0;    ///< first row in position
  double t_end_s = 0.0;     ///< last row
};

struct PlannedRow {
  double t_s = 0.0;
  std::size_t visit = 0;
  calib::Phase phase = calib::Phase::soak;
  std::int32_t position = -1;  ///< index into RunPlan::positions; −1 = on the way
  Attitude attitude;
};

/// All that the station does in one run, row by row.
struct RunPlan {
  std::array<calib::Position, 6> positions;
  std::vector<Visit> visits;
  std::vector<PlannedRow> rows;
};

/// A visit has `ramp_rows` rows of phase ramp (but not the first visit), during which the fixture already stands in
/// the first position, then `rows_per_position` rows in each position with `moving_rows` rows between positions.
[[nodiscard]] RunPlan plan_run(const CampaignConfig& config, const std::vector<SetPoint>& set_points, int run);

}  // namespace soak::hal::sim
