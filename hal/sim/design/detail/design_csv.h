// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "hal/sim/design/detail/designed_campaign.h"

namespace soak::hal::sim {

/// All rows of a unit in a designed campaign, in the format that `soak import` reads. `t_s` and `t_since_power_s` count
/// from each power-on. Where logs are missing there are no columns chamber_c, compressor and supply_v.
[[nodiscard]] std::string design_csv(const CampaignConfig& config, const CampaignCourse& course,
                                     const DesignedUnit& designed);

}  // namespace soak::hal::sim
