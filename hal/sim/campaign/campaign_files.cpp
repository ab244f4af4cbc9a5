// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/campaign_files.h"

#include <filesystem>
#include <vector>

#include "hal/sim/campaign/detail/csv_writer.h"
#include "hal/sim/campaign/output_files.h"
#include "hal/sim/campaign/simulated_run.h"
#include "hal/sim/campaign/truth_writer.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {
namespace {

namespace fs = std::filesystem;

std::string campaign_csv(const CampaignConfig& config, const SimulatedUnit& unit) {
  std::string csv(kCsvHeader);
  for (int run = 1; run <= config.runs; ++run) append_csv_rows(simulate_campaign_run(config, unit, run), csv);
  return csv;
}

std::string verification_csv(const CampaignConfig& config, const SimulatedUnit& unit) {
  std::string csv(kCsvHeader);
  append_csv_rows(simulate_verification_run(config, unit), csv);
  return csv;
}

}  // namespace

base::Status write_campaign(const CampaignConfig& config, const std::string& folder) {
  const fs::path campaign = fs::path(folder) / "campaign";
  const fs::path verification = fs::path(folder) / "verification";
  if (base::Status made = make_folder(campaign); !made) return made;
  if (base::Status made = make_folder(verification); !made) return made;

  std::vector<SimulatedUnit> units;
  for (int number = 1; number <= config.units; ++number) {
    units.push_back(draw_unit(config, number));
    const SimulatedUnit& unit = units.back();
    const std::string name = unit.serial + ".csv";
    if (base::Status written = write_file(campaign / name, campaign_csv(config, unit)); !written) return written;
    if (base::Status written = write_file(verification / name, verification_csv(config, unit)); !written)
      return written;
  }
  return write_file(fs::path(folder) / "truth.json", truth_json(config, units, campaign_runs(config)));
}

}  // namespace soak::hal::sim
