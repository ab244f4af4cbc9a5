// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/design_files.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "hal/sim/campaign/output_files.h"
#include "hal/sim/design/detail/design_csv.h"
#include "hal/sim/design/detail/design_truth.h"

namespace soak::hal::sim {

base::Status write_designed_campaign(const CampaignConfig& config, const std::string& folder,
                                     const std::optional<std::string>& truth_file) {
  const std::filesystem::path campaign = std::filesystem::path(folder) / "campaign";
  const CampaignCourse course = campaign_course(config);
  std::vector<DesignedUnit> units;
  for (int number = 1; number <= config.units; ++number) {
    auto unit = simulate_designed_unit(config, course, number);
    if (!unit) return base::forward_error(unit);
    if (base::Status made = make_folder(campaign); !made) return made;
    const std::string csv = design_csv(config, course, *unit);
    if (base::Status written = write_file(campaign / (unit->unit.serial + ".csv"), csv); !written) return written;
    unit->rows.clear();
    units.push_back(*std::move(unit));
  }
  if (!truth_file) return {};
  return write_file(*truth_file, design_truth_json(config, course, units));
}

}  // namespace soak::hal::sim
