// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "hal/sim/campaign_config.h"
#include "hal/sim/simulated_unit.h"

namespace soak::hal::sim {

/// JSON text of what is true of the units, for judging what was found out about them. Its format stands in README.md.
[[nodiscard]] std::string truth_json(const CampaignConfig& config, const std::vector<SimulatedUnit>& units);

}  // namespace soak::hal::sim
