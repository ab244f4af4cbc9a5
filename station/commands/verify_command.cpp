// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "calib/verification.h"
#include "station/calibration_reader.h"
#include "station/commands/calibration_commands.h"
#include "station/data_folder.h"
#include "station/fit_unit.h"
#include "station/limits_file.h"

namespace soak::station {
namespace {

base::Result<calib::UnitInput> load_campaign(const db::Catalog& catalog, const calib::Calibration& calibration,
                                             const std::string& campaign) {
  const auto runs = catalog.runs({.unit = calibration.unit, .campaign = campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  calib::UnitInput input;
  input.unit = calibration.unit;
  input.type.name = calibration.unit_type;
  input.epoch = calibration.epoch;
  for (const db::RunRow& run : *runs) {
    // A pre-flight records units that have not settled.
    if (!run.sealed || run.voided || run.epoch != calibration.epoch || run.purpose == "diagnosis") continue;
    auto loaded = load_run(catalog, run);
    if (!loaded) return base::forward_error(loaded);
    input.runs.push_back(*std::move(loaded));
  }
  if (input.runs.empty()) {
    return base::bad_input(
        fmt::format("campaign '{}' has no sealed, unvoided run of unit {} in epoch {} but for diagnosis ({} runs of "
                    "it in all); 'soak runs list' shows what there is",
                    campaign, calibration.unit, calibration.epoch, runs->size()));
  }
  return input;
}

nlohmann::json document_of(const calib::Calibration& calibration, const calib::Verification& verification) {
  nlohmann::json sensors = nlohmann::json::object();
  nlohmann::json warnings = nlohmann::json::array();
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& result = verification.sensors[calib::index_of(sensor)];
    if (!result) continue;
    const double factor = calib::printed_per_si(sensor);
    sensors[std::string(calib::name_of(sensor))] = {
        {"verdict", calib::name_of(result->verdict)},
        {"worst_abs", result->worst_abs * factor},
        {"worst_temp_c", result->worst_temp_c},
        {"rmse_abs", result->rmse_abs * factor},
        {"rmse_shape", result->rmse_shape * factor},
        {"rows", result->rows},
        {"limit", result->limit ? nlohmann::json(*result->limit * factor) : nlohmann::json()}};
  }
  for (const calib::Warning& warning : verification.warnings) {
    warnings.push_back({{"code", warning.code}, {"text", warning.text}});
  }
  return {{"unit", calibration.unit},
          {"model", calibration.model_version},
          {"verdict", calib::name_of(verification.verdict)},
          {"sensors", std::move(sensors)},
          {"warnings", std::move(warnings)}};
}

std::string describe(const calib::Calibration& calibration, const calib::Verification& verification) {
  std::vector<std::vector<std::string>> table = {
      {"sensor", "unit", "verdict", "worst", "at °C", "rmse", "shape", "limit", "rows"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& result = verification.sensors[calib::index_of(sensor)];
    if (!result) continue;
    const double factor = calib::printed_per_si(sensor);
    table.push_back({std::string(calib::name_of(sensor)), std::string(calib::printed_unit(sensor)),
                     std::string(calib::name_of(result->verdict)), fmt::format("{:.5f}", result->worst_abs * factor),
                     fmt::format("{:.1f}", result->worst_temp_c), fmt::format("{:.5f}", result->rmse_abs * factor),
                     fmt::format("{:.5f}", result->rmse_shape * factor),
                     result->limit ? fmt::format("{:.5f}", *result->limit * factor) : "-",
                     std::to_string(result->rows)});
  }
  return fmt::format("unit {}, model {}: {}\n{}", calibration.unit, calibration.model_version,
                     calib::name_of(verification.verdict), text_table(table));
}

}  // namespace

base::Status run_verify(const VerifyCommand& command, Output& output) {
  const auto loaded = read_calibration(command.file);
  if (!loaded) return base::forward_error(loaded);
  const auto limits = command.limits.empty() ? base::Result<calib::Limits>() : read_limits(command.limits);
  if (!limits) return base::forward_error(limits);
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto runs = load_campaign(*catalog, loaded->calibration, command.campaign);
  if (!runs) return base::forward_error(runs);
  const auto verification = calib::verify(loaded->calibration, *runs, *limits);
  if (!verification) return base::forward_error(verification);

  if (output.json()) {
    if (const auto printed = output.print_json(document_of(loaded->calibration, *verification)); !printed)
      return printed;
  } else {
    for (const calib::Warning& warning : verification->warnings) output.note("warning: " + warning.text);
    output.print(describe(loaded->calibration, *verification));
  }
  if (verification->verdict == calib::Verdict::fail) {
    return base::fail(base::ErrorKind::limits, "the unit fails its limits", loaded->calibration.unit);
  }
  return {};
}

}  // namespace soak::station
