// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calib/vocabulary/run.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/design/detail/run_profile.h"
#include "hal/sim/effects/conditions.h"

namespace soak::hal::sim {

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
struct CourseRun {
  std::string label;  ///< "R01"...
  int pass = 0;
  double utc_s = 0.0;
};

/// All that happens in a designed campaign to every unit alike: temperatures, positions, power, compressor, supply.
/// Before each pass the chamber goes from room temperature to the first set point while the units are off. The first
/// visit begins a minute after power-on; rows lie 10 s apart, with one moving row between positions.
struct CampaignCourse {
  std::vector<RunProfile> passes;
  Mistakes mistakes;
  std::vector<CourseRun> runs;
  std::vector<Moment> moments;  ///< in order of time
};

inline constexpr double kDesignRowInterval_s = 10.0;
inline constexpr int kRowsPerBlock = 6;

/// A function of `config` alone, which must have a design.
[[nodiscard]] CampaignCourse campaign_course(const CampaignConfig& config);

/// The set points of a design, the coldest first.
[[nodiscard]] std::vector<double> design_set_points_c(const DesignConfig& design);

/// What of a moment's row reaches the file: nothing of a dropped visit, no ramps where logs are missing.
[[nodiscard]] bool is_written(const CampaignCourse& course, const DesignConfig& design, const Moment& moment);

/// Label of a row's position; empty = on the way.
[[nodiscard]] std::string position_label(const CampaignCourse& course, const Moment& moment);

}  // namespace soak::hal::sim
