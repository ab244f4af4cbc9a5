// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "calib/vocabulary/position.h"
#include "hal/sim/config/campaign_config.h"

namespace soak::hal::sim {

/// How one pass through the chamber is done.
struct RunProfile {
  std::vector<int> set_points;  ///< visited, in order: indices from 0, the coldest
  double ramp_kps = 0.0;
  double soak_s = 0.0;  ///< from the end of a ramp to the first block
  std::array<calib::Position, 6> positions;
  int power_cycle_visit = -1;  ///< the power is off for a moment before the ramp to this visit; −1 = never
};

/// The passes of a campaign. All are alike, up from the coldest set point and down again, but those of
/// DesignKind::mixed: there ramps are 0.5 to 2 times and soaks 0.6 to 2 times as long as the design says; a pass begins
/// cold, hot or in the middle, or goes in double steps; the positions come in the orders of position_order(); and one
/// pass has a power cycle. A function of the configuration alone.
[[nodiscard]] std::vector<RunProfile> run_profiles(const DesignConfig& design, std::uint64_t seed);

/// A visit of a pass, for mistakes.
struct PlannedVisit {
  int pass = -1;
  int visit = -1;
  int position = -1;  ///< ordinal in the visit

  bool operator==(const PlannedVisit&) const = default;
};

/// What goes wrong in a campaign whose design asks for it; −1 where nothing does.
struct Mistakes {
  PlannedVisit dropped;           ///< not recorded
  PlannedVisit wrongly_labelled;  ///< one of its positions has the label of the opposite one
};

[[nodiscard]] Mistakes drawn_mistakes(const DesignConfig& design, std::uint64_t seed);

}  // namespace soak::hal::sim
