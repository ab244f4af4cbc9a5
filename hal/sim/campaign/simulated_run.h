// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/vocabulary/recording.h"
#include "hal/sim/campaign/run_plan.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {

/// What the station would record of `unit` in run `run` that passes through `set_points`: SI, every channel in every
/// row, auxiliary channel `chamber_c`. `run_id` is run_label(run). The numbers depend on (configuration, unit, run)
/// alone.
[[nodiscard]] calib::Recording simulate_run(const CampaignConfig& config, const SimulatedUnit& unit, int run,
                                            const std::vector<SetPoint>& set_points);

/// Run `run` (from 1) of the campaign.
[[nodiscard]] calib::Recording simulate_campaign_run(const CampaignConfig& config, const SimulatedUnit& unit, int run);

/// The verification run: between the plateaus, with a power-on offset of its own.
[[nodiscard]] calib::Recording simulate_verification_run(const CampaignConfig& config, const SimulatedUnit& unit);

}  // namespace soak::hal::sim
