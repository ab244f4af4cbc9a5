// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "db/run/run_file.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/data_folder.h"
#include "station/io/text_file.h"
#include "station/records/calibration_reader.h"
#include "station/runs/corrected_run.h"
#include "station/runs/recording_reader.h"

namespace soak::station {
namespace {

/// soak correct FILE.blob RUN: the run as a device with this file would correct it.
struct CorrectCommand final : CatalogCommand {
  std::string file;
  db::RunFilter filter;
  std::string past = "unknown";
  std::string target;  ///< empty = no CSV file

  void declare(OptionList& options) override {
    options.add("file FILE.blob", &file, "Calibration file").required();
    declare_run(options, filter);
    options.add("--past WAY", &past, "How the unit came to its first temperature: what a thermal history starts with")
        .one_of({"unknown", "heating", "cooling"})
        .with_default();
    options.add("-o,--output FILE.csv", &target, "Means of 30 s in one position, raw and corrected");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// RMS of a sensor's blocks, raw or corrected, about the mean of their position; absent without any. Of both the same
/// blocks, where any was corrected.
std::optional<double> scatter_of(const CorrectedRun& run, calib::Sensor sensor, bool corrected) {
  const std::size_t s = calib::index_of(sensor);
  const bool any =
      std::ranges::any_of(run.blocks, [&](const CorrectedBlock& block) { return block.corrected[s].has_value(); });
  std::map<std::string, std::vector<double>> positions;
  for (const CorrectedBlock& block : run.blocks) {
    const auto& value = corrected ? block.corrected[s] : block.raw[s];
    if (value && (!any || block.corrected[s])) positions[block.position].push_back(*value);
  }
  double squares = 0.0;
  double count = 0.0;
  for (const auto& [position, values] : positions) {
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    for (const double value : values) squares += (value - mean) * (value - mean);
    count += static_cast<double>(values.size());
  }
  if (count == 0.0) return std::nullopt;
  return std::sqrt(squares / count) * calib::printed_per_si(sensor);
}

nlohmann::json corrected_json(const LoadedCalibration& loaded, const db::RunRow& row, const CorrectCommand& command,
                              const CorrectedRun& run) {
  nlohmann::json sensors = nlohmann::json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto raw = scatter_of(run, sensor, false);
    if (!raw) continue;
    sensors[std::string(calib::name_of(sensor))] = {{"unit", calib::printed_unit(sensor)},
                                                    {"raw_rms", *raw},
                                                    {"corrected_rms", number_or_null(scatter_of(run, sensor, true))}};
  }
  return {{"unit", loaded.calibration.unit},
          {"model", loaded.calibration.model_version},
          {"run", row.label},
          {"run_id", row.run_id},
          {"past", command.past},
          {"file", command.target.empty() ? nlohmann::json() : nlohmann::json(command.target)},
          {"rows", run.rows},
          {"rows_clamped", run.clamped},
          {"blocks", run.blocks.size()},
          {"moving_terms", run.moving},
          {"thermal_history", run.history},
          {"unknown_at_end", run.unknown_at_end},
          {"sensors", std::move(sensors)}};
}

std::string corrected_text(const LoadedCalibration& loaded, const db::RunRow& row, const CorrectCommand& command,
                           const CorrectedRun& run) {
  std::vector<std::vector<std::string>> table = {{"sensor", "unit", "raw", "corrected"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto raw = scatter_of(run, sensor, false);
    if (!raw) continue;
    const auto corrected = scatter_of(run, sensor, true);
    table.push_back({std::string(calib::name_of(sensor)), std::string(calib::printed_unit(sensor)),
                     fmt::format("{:.5f}", *raw), corrected ? fmt::format("{:.5f}", *corrected) : "–"});
  }
  std::string text = fmt::format(
      "unit {}, model {}, run {}: {} rows, {} of them out of range; RMS of means of 30 s about that of their "
      "position\n",
      loaded.calibration.unit, loaded.calibration.model_version, row.label, run.rows, run.clamped);
  if (run.history) {
    text += fmt::format("thermal history followed, past {}; at the end {:.2g} of it is unknown\n", command.past,
                        run.unknown_at_end);
  }
  return text + text_table(table);
}

base::Status CorrectCommand::run_with(db::Catalog& catalog, Output& output) {
  const auto loaded = read_calibration(file);
  if (!loaded) return base::forward_error(loaded);
  if (!filter.unit) filter.unit = loaded->calibration.unit;
  const auto row = find_run(catalog, filter);
  if (!row) return base::forward_error(row);
  if (row->unit != loaded->calibration.unit) {
    return base::bad_input(
        fmt::format("the file is of unit {}, the run of unit {}", loaded->calibration.unit, row->unit), file);
  }
  const auto samples = catalog.open_run_file(*row);
  if (!samples) return base::forward_error(samples);
  const auto recording = read_recording(*samples, row->unit);
  if (!recording) return base::forward_error(recording);
  const double start = past == "heating" ? 1.0 : past == "cooling" ? -1.0 : 0.0;
  const auto run = correct_run(loaded->bytes, *recording, start);
  if (!run) return base::forward_error(run);
  if (!target.empty()) {
    if (auto written = write_text_file(target, corrected_csv(*run)); !written) return written;
  }
  note_waivers(loaded->calibration.references, output);
  if (output.json()) return output.print_json(corrected_json(*loaded, *row, *this, *run));
  output.print(corrected_text(*loaded, *row, *this, *run));
  return {};
}

}  // namespace

CommandGroup correct_commands() {
  return {"",
          "",
          {{"correct", "A stored run as a device with a calibration file would correct it",
            "soak correct SN0042.soakcal R07 --past heating -o corrected.csv", std::make_shared<CorrectCommand>()}}};
}

}  // namespace soak::station
