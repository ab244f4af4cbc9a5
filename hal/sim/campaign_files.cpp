// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign_files.h"

#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include "hal/sim/csv_writer.h"
#include "hal/sim/simulated_run.h"
#include "hal/sim/simulated_unit.h"
#include "hal/sim/truth_writer.h"

namespace soak::hal::sim {
namespace {

namespace fs = std::filesystem;

base::Status make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return base::bad_input("cannot make this folder (" + error.message() + ")", folder.string());
  return {};
}

base::Status write_file(const fs::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) return base::fail(base::ErrorKind::internal, "cannot write this file", path.string());
  return {};
}

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
