// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/campaign_files.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <vector>

#include "hal/sim/campaign/simulated_run.h"
#include "hal/sim/campaign/truth_writer.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {
namespace {

/// First line of a CSV file, with its line end.
constexpr std::string_view kCsvHeader =
    "t_s,run,phase,sweep,plateau_c,position,chamber_c,temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2\n";

/// Appends one line per row of a recording that simulate_run() made. Decimals are fixed: 1e-5 deg/s, 1e-5 m/s², 1e-4
/// °C.
void append_csv_rows(const calib::Recording& recording, std::string& csv) {
  auto out = std::back_inserter(csv);
  const std::vector<double>& chamber_c = recording.auxiliary.front().values;
  for (std::size_t i = 0; i < recording.rows(); ++i) {
    const std::int32_t position = recording.position[i];
    const std::string_view label =
        position < 0 ? std::string_view() : recording.positions[static_cast<std::size_t>(position)].label;
    fmt::format_to(out, "{:.3f},{},{},{},{},{},{:.3f},{:.4f}", recording.t_s[i], recording.run_id,
                   recording.phase[i] == calib::Phase::ramp ? "ramp" : "soak", calib::name_of(recording.sweep[i]),
                   recording.plateau_c[i], label, chamber_c[i], recording.temp_c[i]);
    for (const calib::Sensor sensor : calib::kSensors) {
      const double printed = recording.sensor[calib::index_of(sensor)][i] * calib::printed_per_si(sensor);
      fmt::format_to(out, ",{:.5f}", printed);
    }
    csv += '\n';
  }
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

base::Status make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return base::bad_input("cannot make this folder (" + error.message() + ")", folder.string());
  return {};
}

base::Status write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) return base::fail(base::ErrorKind::internal, "cannot write this file", path.string());
  return {};
}

base::Status write_campaign(const CampaignConfig& config, const std::string& folder) {
  const std::filesystem::path campaign = std::filesystem::path(folder) / "campaign";
  const std::filesystem::path verification = std::filesystem::path(folder) / "verification";
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
  return write_file(std::filesystem::path(folder) / "truth.json", truth_json(config, units, campaign_runs(config)));
}

}  // namespace soak::hal::sim
