// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "base/result.h"
#include "hal/sim/design/detail/campaign_timeline.h"
#include "hal/sim/design/detail/effect_size.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {

/// What the station records of one moment of a designed campaign.
struct DesignedRow {
  std::size_t moment = 0;
  double chamber_c = 0.0;
  double temp_c = 0.0;                               ///< of the thermometer
  std::array<double, calib::kSensorCount> sensor{};  ///< rad/s and m/s²
};

/// One unit in a designed campaign.
struct DesignedUnit {
  SimulatedUnit unit;
  std::vector<SizedEffect> effects;     ///< in the order of the configuration
  std::vector<SizedEffect> candidates;  ///< likewise; not in `rows`
  std::vector<PlannedBlock> blocks;
  std::vector<DesignedRow> rows;  ///< those that are written
};

/// The `number`-th unit of config.seed, as in other campaigns; without g-sensitivity unless the design keeps what is
/// known.
[[nodiscard]] SimulatedUnit draw_designed_unit(const CampaignConfig& config, int number);

/// All that is recorded of the `number`-th unit in a campaign, which campaign_timeline(config) is. The same
/// configuration gives the same numbers. Errors (bad_input): a magnitude that cannot be reached.
[[nodiscard]] base::Result<DesignedUnit> simulate_designed_unit(const CampaignConfig& config,
                                                                const CampaignTimeline& timeline, int number);

}  // namespace soak::hal::sim
