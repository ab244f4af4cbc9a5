// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "hal/sim/design/detail/designed_campaign.h"

namespace soak::hal::sim {

/// JSON text of what is hidden in a designed campaign. Its format stands in hal/sim/README.md. Rows are not read.
[[nodiscard]] std::string design_truth_json(const CampaignConfig& config, const CampaignCourse& course,
                                            const std::vector<DesignedUnit>& units);

/// Largest half of the difference between a sensor's mean contributions on the way up and on the way down at the same
/// set point, of all runs; 0 where no set point is reached both ways.
[[nodiscard]] double largest_half_gap(const CampaignCourse& course, const std::vector<PlannedBlock>& blocks,
                                      const std::vector<double>& contributions);

}  // namespace soak::hal::sim
