// SPDX-License-Identifier: Apache-2.0
#include "station/report/runs_of_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "calib/estimate/site.h"
#include "calib/estimate/unit_input.h"
#include "db/run/run_file.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"
#include "station/io/output.h"

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

/// The references as the fit took them: one that corrected rates and voltages has stored in which campaigns.
std::vector<calib::ReferenceUse> as_fitted(std::vector<calib::ReferenceUse> uses) {
  for (calib::ReferenceUse& use : uses) {
    if (use.campaigns.empty() && use.reference.kind != calib::ReferenceKind::gravity) use.reference.correction.reset();
  }
  return uses;
}

/// Whether a label is not enough to tell a run: one of another campaign has the same.
bool is_ambiguous(const std::vector<UsedRun>& runs, const db::RunRow& run) {
  return std::ranges::any_of(
      runs, [&](const UsedRun& other) { return other.run.label == run.label && other.run.campaign != run.campaign; });
}

/// "R01, R02"; "R01 of campaign a, R02 of campaign b" where they are of several campaigns or a label alone would not
/// tell which.
template <class Condition>
std::string labels_where(const std::vector<UsedRun>& runs, Condition condition) {
  std::vector<const db::RunRow*> found;
  for (const UsedRun& run : runs) {
    if (condition(run)) found.push_back(&run.run);
  }
  const bool with_campaign = std::ranges::any_of(found, [&](const db::RunRow* run) {
    return run->campaign != found.front()->campaign || is_ambiguous(runs, *run);
  });
  std::vector<std::string> names;
  for (const db::RunRow* run : found) {
    names.push_back(with_campaign ? fmt::format("{} of campaign {}", run->label, run->campaign) : run->label);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<calib::Warning> warnings_of(const RunsOfModel& found, const std::vector<std::string>& missing,
                                        double model_utc_s) {
  std::vector<calib::Warning> warnings;
  for (const std::string& hash : missing) {
    warnings.push_back(
        {"run_missing",
         fmt::format("a run that the model was fitted to is not in this data folder (content {})", hash)});
  }
  const std::string voided = labels_where(found.runs, [&](const UsedRun& run) {
    return run.use == RunUse::fitted && std::any_of(run.voids.begin(), run.voids.end(),
                                                    [&](const auto& record) { return record.utc_s > model_utc_s; });
  });
  if (!voided.empty()) {
    warnings.push_back(
        {"voided_since", fmt::format("withdrawn, whole or in part, after the model was fitted to it: {}", voided)});
  }
  const std::string unused = labels_where(found.runs, [](const UsedRun& run) { return run.use == RunUse::not_used; });
  if (!unused.empty()) {
    warnings.push_back({"not_in_model", fmt::format("recorded or entered, but not in this model: {}", unused)});
  }
  return warnings;
}

using nlohmann::json;

/// Void records of one kind: the whole run, or parts of it withdrawn for one reason by one user.
struct VoidGroup {
  bool whole = false;
  std::string reason;
  std::string user;
  double utc_s = 0.0;  ///< of the first
  std::size_t records = 0;
};

/// The station withdraws each repeated segment on its own: hundreds of records may say the same.
std::vector<VoidGroup> void_groups_of(const std::vector<db::VoidRecord>& voids) {
  std::vector<VoidGroup> list;
  for (const db::VoidRecord& record : voids) {
    const bool whole = !record.visit;
    const auto same = std::find_if(list.begin(), list.end(), [&](const VoidGroup& other) {
      return other.whole == whole && other.reason == record.reason && other.user == record.user;
    });
    if (same == list.end()) {
      list.push_back({whole, record.reason, record.user, record.utc_s, 1});
    } else {
      same->utc_s = std::min(same->utc_s, record.utc_s);
      ++same->records;
    }
  }
  return list;
}

json voids_json(const std::vector<db::VoidRecord>& voids) {
  json list = json::array();
  for (const VoidGroup& entry : void_groups_of(voids)) {
    list.push_back({{"what", entry.whole ? "run" : "segments"},
                    {"records", entry.records},
                    {"reason", entry.reason},
                    {"user", entry.user},
                    {"utc_s", entry.utc_s}});
  }
  return list;
}

/// Where the samples came from, as the run file says or said; null where it cannot be read.
json source_of(const db::Catalog& catalog, const db::RunRow& run) {
  if (run.samples_dropped) return run.samples_dropped->source;
  const auto file = catalog.open_run_file(run);
  return file ? json(file->info().source) : json();
}

/// `gravity`: as a fit takes it for this run.
json run_json(const db::Catalog& catalog, const UsedRun& used, const calib::Gravity& gravity) {
  const db::RunRow& run = used.run;
  return {{"label", run.label},
          {"run_id", run.run_id},
          {"campaign", run.campaign},
          {"procedure", run.procedure},
          {"purpose", run.purpose},
          {"epoch", run.epoch},
          {"created_utc_s", run.created_utc_s},
          {"duration_s", run.duration_s},
          {"rows", run.rows},
          {"source", source_of(catalog, run)},
          {"clock_rate", run.clock_rate},
          {"simulated", run.simulated},
          {"gravity_mps2", gravity.mps2},
          {"gravity", gravity.assumed ? "assumed" : "known"},
          {"latitude_deg", number_or_null(run.site.latitude_deg)},
          {"height_m", number_or_null(run.site.height_m)},
          {"content_sha256", run.content_sha256},
          {"use", name_of(used.use)},
          {"voids", voids_json(used.voids)}};
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
    auto loaded = load_run(catalog, used.run, input->type);
    if (!loaded) return base::forward_error(loaded);
    input->runs.push_back(*std::move(loaded));
  }
  calib::leave_out_copies(input->runs, warnings);
  if (use == RunUse::fitted) {
    input->references = as_fitted(calibration.references);
    return input;
  }
  std::vector<std::string> campaigns;
  for (const calib::RunInput& run : input->runs) campaigns.push_back(run.campaign);
  auto references = references_of_campaigns(catalog, campaigns);
  if (!references) return base::forward_error(references);
  input->references = *std::move(references);
  return input;
}

base::Result<json> provenance_json(const db::Catalog& catalog, const db::ModelRow& model,
                                   const calib::Calibration& calibration, const RunsOfModel& runs) {
  json list = json::array();
  for (const UsedRun& used : runs.runs) {
    const auto references = references_of(catalog, calibration, used);
    if (!references) return base::forward_error(references);
    list.push_back(run_json(catalog, used, gravity_at(with_reference_gravity(used.run.site, *references))));
  }
  base::Sha256 hash;
  hash.update(model.document);
  return json{{"model_sha256", base::to_hex(hash.finish())}, {"runs", std::move(list)}};
}

}  // namespace soak::station
