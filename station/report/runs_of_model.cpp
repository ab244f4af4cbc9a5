// SPDX-License-Identifier: Apache-2.0
#include "station/report/runs_of_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>

#include "calib/estimate/unit_input.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"

namespace soak::station {
namespace {

/// Whether the run as a whole was withdrawn before a time: a fit then took the copy that was imported in its place.
bool was_void(const std::vector<db::VoidRecord>& voids, double utc_s) {
  return std::ranges::any_of(voids,
                             [utc_s](const db::VoidRecord& record) { return !record.visit && record.utc_s <= utc_s; });
}

RunUse use_of(const db::RunRow& run, bool could_be_fitted, std::vector<std::string>& hashes) {
  const auto listed = std::find(hashes.begin(), hashes.end(), run.content_sha256);
  if (could_be_fitted && run.purpose == "calibration" && listed != hashes.end()) {
    hashes.erase(listed);
    return RunUse::fitted;
  }
  if (run.voided) return RunUse::voided;
  if (!run.sealed) return RunUse::unsealed;
  if (run.purpose == "verification") return RunUse::fresh;
  return run.purpose == "diagnosis" ? RunUse::diagnosis : RunUse::not_used;
}

/// "R01, R02"
template <class Condition>
std::string labels_where(const std::vector<UsedRun>& runs, Condition condition) {
  std::vector<std::string> labels;
  for (const UsedRun& run : runs) {
    if (condition(run)) labels.push_back(run.run.label);
  }
  return fmt::format("{}", fmt::join(labels, ", "));
}

std::vector<calib::Warning> warnings_of(const RunsOfModel& found, const std::vector<std::string>& missing,
                                        double model_utc_s) {
  std::vector<calib::Warning> warnings;
  for (const std::string& hash : missing) {
    warnings.push_back({"run_missing", fmt::format("a run that the model was fitted to is not in this data folder "
                                                   "(content {})",
                                                   hash)});
  }
  const std::string voided = labels_where(found.runs, [&](const UsedRun& run) {
    return run.use == RunUse::fitted && std::any_of(run.voids.begin(), run.voids.end(),
                                                    [&](const auto& record) { return record.utc_s > model_utc_s; });
  });
  if (!voided.empty()) {
    warnings.push_back({"voided_since", fmt::format("withdrawn, whole or in part, after the model was fitted to it: "
                                                    "{}",
                                                    voided)});
  }
  const std::string unused = labels_where(found.runs, [](const UsedRun& run) { return run.use == RunUse::not_used; });
  if (!unused.empty()) {
    warnings.push_back({"not_in_model", fmt::format("recorded or entered, but not in this model: {}", unused)});
  }
  return warnings;
}

}  // namespace

base::Result<RunsOfModel> runs_of_model(const db::Catalog& catalog, const calib::Calibration& calibration) {
  const auto rows = catalog.runs({.unit = calibration.unit, .campaign = {}, .run = {}});
  if (!rows) return base::forward_error(rows);
  std::vector<std::string> hashes = calibration.run_hashes;
  RunsOfModel found;
  for (const db::RunRow& run : *rows) {
    if (run.epoch != calibration.epoch) continue;
    auto voids = catalog.voids(run.run_id);
    if (!voids) return base::forward_error(voids);
    std::erase_if(*voids, [&](const db::VoidRecord& record) { return record.unit != run.unit; });
    const RunUse use = use_of(run, !was_void(*voids, calibration.created_utc_s), hashes);
    found.runs.push_back({run, use, *std::move(voids)});
  }
  found.warnings = warnings_of(found, hashes, calibration.created_utc_s);
  return found;
}

base::Result<std::vector<calib::ReferenceUse>> references_of(const db::Catalog& catalog,
                                                             const calib::Calibration& calibration,
                                                             const UsedRun& run) {
  if (run.use == RunUse::fitted) return calibration.references;
  return references_of_campaigns(catalog, {run.run.campaign});
}

base::Result<calib::UnitInput> input_of(const db::Catalog& catalog, const calib::Calibration& calibration,
                                        const RunsOfModel& runs, RunUse use, std::vector<calib::Warning>& warnings) {
  auto input = unit_of(calibration);
  if (!input) return base::forward_error(input);
  for (const UsedRun& used : runs.runs) {
    if (used.use != use || used.run.voided) continue;
    auto loaded = load_run(catalog, used.run);
    if (!loaded) return base::forward_error(loaded);
    input->runs.push_back(*std::move(loaded));
  }
  calib::leave_out_copies(input->runs, warnings);
  if (use == RunUse::fitted) {
    input->references = calibration.references;
    return input;
  }
  std::vector<std::string> campaigns;
  for (const calib::RunInput& run : input->runs) campaigns.push_back(run.campaign);
  auto references = references_of_campaigns(catalog, campaigns);
  if (!references) return base::forward_error(references);
  input->references = *std::move(references);
  return input;
}

}  // namespace soak::station
