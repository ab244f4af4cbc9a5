// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "hal/sim/config/campaign_config.h"

namespace soak::hal::sim {

/// Writes the campaign of `config.design`: `campaign/SERIAL.csv` in `folder`, all runs of a unit in one file, and what
/// is hidden in it to `truth_file` and nowhere else. Errors as write_campaign(); also a magnitude that cannot be
/// reached (bad_input), after which the files of the units before remain.
[[nodiscard]] base::Status write_designed_campaign(const CampaignConfig& config, const std::string& folder,
                                                   const std::optional<std::string>& truth_file);

}  // namespace soak::hal::sim
