// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"
#include "hal/sim/config/campaign_config.h"

namespace soak::hal::sim {

/// Writes `campaign/SERIAL.csv` (all runs of a unit), `verification/SERIAL.csv` (its verification run) and `truth.json`
/// into `folder`, which is made where it is missing; files of these names are replaced, others left. The same
/// configuration gives the same bytes. Errors: a folder that cannot be made (bad_input), a file that cannot be written
/// (internal).
[[nodiscard]] base::Status write_campaign(const CampaignConfig& config, const std::string& folder);

/// Makes a folder, and those above it, where it is missing. Error: bad_input.
[[nodiscard]] base::Status make_folder(const std::filesystem::path& folder);

/// Writes or replaces a file. Error: internal.
[[nodiscard]] base::Status write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace soak::hal::sim
