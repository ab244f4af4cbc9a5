// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "calib/vocabulary/position.h"
#include "calib/vocabulary/run.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/effects/conditions.h"

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

/// One moment of a designed campaign, mostly a row.
struct Moment {
  Conditions conditions;
  calib::Vector3 rate_rps{};  ///< rotation of the body against inertial space
  bool recorded = false;      ///< a row of the station's log
  calib::Phase phase = calib::Phase::soak;
  calib::Sweep sweep = calib::Sweep::unknown;  ///< of the visit
  int visit = -1;                              ///< ordinal in the pass; −1 before power-on
  int set_point = -1;                          ///< index from the coldest
  int position = -1;                           ///< ordinal in the visit; −1 = on the way
  int block = -1;                              ///< ordinal in the position
};

/// A power-on.
struct TimelineRun {
  std::string label;  ///< "R01"...
  int pass = 0;
  double utc_s = 0.0;
};

/// All that happens in a designed campaign to every unit alike: temperatures, positions, power, compressor, supply.
/// Before each pass the chamber goes from room temperature to the first set point while the units are off. The first
/// visit begins a minute after power-on; rows lie 10 s apart, with one moving row between positions.
struct CampaignTimeline {
  std::vector<RunProfile> passes;
  Mistakes mistakes;
  std::vector<TimelineRun> runs;
  std::vector<Moment> moments;  ///< in order of time
};

inline constexpr double kDesignRowInterval_s = 10.0;
inline constexpr int kRowsPerBlock = 6;

/// A function of `config` alone, which must have a design.
[[nodiscard]] CampaignTimeline campaign_timeline(const CampaignConfig& config);

/// The set points of a design, the coldest first.
[[nodiscard]] std::vector<double> design_set_points_c(const DesignConfig& design);

/// What of a moment's row reaches the file: nothing of a dropped visit, no ramps where logs are missing.
[[nodiscard]] bool is_written(const CampaignTimeline& timeline, const DesignConfig& design, const Moment& moment);

/// Label of a row's position; empty = on the way.
[[nodiscard]] std::string position_label(const CampaignTimeline& timeline, const Moment& moment);

}  // namespace soak::hal::sim
