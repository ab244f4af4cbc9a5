// SPDX-License-Identifier: Apache-2.0
#include "station/report/report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/judge/report_json.h"
#include "calib/model/deployed_terms.h"
#include "calib/model/document_parts.h"
#include "calib/model/model_document.h"
#include "station/config/unit_type_file.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"
#include "station/io/data_folder.h"
#include "station/io/output.h"
#include "station/io/text.h"
#include "station/nav/free_inertial.h"
#include "station/records/check_standard.h"
#include "station/records/signing.h"
#include "station/report/release_part.h"
#include "station/report/runs_of_model.h"
#include "station/runs/still_segment.h"

namespace soak::station {
namespace {

using nlohmann::json;

// ---- noise ----

json segment_json(const StillSegment& still) {
  const calib::Segment& segment = still.segment;
  return {{"run", still.run.label},
          {"campaign", still.run.campaign},
          {"content_sha256", still.run.content_sha256},
          {"simulated", still.run.simulated},
          {"visit", segment.key.visit},
          {"position", segment.key.position},
          {"plateau_c", number_or_null(segment.plateau_c)},
          {"temp_c", number_or_null(segment.temp_c)},
          {"duration_s", length_s(segment)}};
}

json no_noise(const std::string& reason) {
  return {{"segment", json()}, {"sensors", json::object()}, {"reason", reason}};
}

/// The section `noise` of a report: for each sensor the document of `soak signal allan` of the unit's longest segment
/// at rest in this epoch (still_segment.h). `reason` says why there is
/// nothing where there is nothing. `progress` is told the share that is done, and stops the work (internal) where it
/// returns false.
base::Result<json> noise_json(const db::Catalog& catalog, const std::string& unit, std::int32_t epoch,
                              const std::function<bool(double)>& progress) {
  const auto longest = longest_still_segment(catalog, unit, epoch);
  if (!longest) return base::forward_error(longest);
  if (!*longest) {
    return no_noise("no run of the unit that has its samples has a segment at rest that the data gate accepts");
  }
  json sensors = json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    if (!progress(static_cast<double>(calib::index_of(sensor)) / calib::kSensorCount)) {
      return base::fail(base::ErrorKind::internal, "interrupted; no report was written");
    }
    if ((*longest)->segment.sensor[calib::index_of(sensor)].count == 0) continue;
    auto document = allan_at_rest(catalog, **longest, sensor);
    if (!document) return base::forward_error(document);
    sensors[std::string(calib::name_of(sensor))] = *std::move(document);
  }
  return json{{"segment", segment_json(**longest)}, {"sensors", std::move(sensors)}, {"reason", json()}};
}

// ---- model, limits, records ----

base::Result<db::ModelRow> find_model(const db::Catalog& catalog, const ReportRequest& request) {
  const auto row = catalog.model(request.unit, request.model);
  if (!row) return base::forward_error(row);
  if (*row) return **row;
  return base::bad_input(request.model ? fmt::format("unit {} has no model version {}", request.unit, *request.model)
                                       : fmt::format("unit {} has no model yet; run 'soak fit --unit {}' first",
                                                     request.unit, request.unit));
}

/// Whether the model is the one that the unit would be deployed with today.
base::Result<std::vector<calib::Warning>> age_warnings(const db::Catalog& catalog, const db::UnitRow& unit,
                                                       const db::ModelRow& model) {
  std::vector<calib::Warning> warnings;
  if (model.epoch != unit.epoch) {
    warnings.push_back(
        {"older_epoch",
         fmt::format("the model belongs to epoch {}; the unit has been repaired or re-flashed since and is in epoch {}",
                     model.epoch, unit.epoch)});
  }
  const auto newest = catalog.model(unit.serial);
  if (!newest) return base::forward_error(newest);
  if (*newest && (*newest)->version != model.version) {
    warnings.push_back(
        {"older_model", fmt::format("this is model {}; the newest is {}", model.version, (*newest)->version)});
  }
  return warnings;
}

/// Those of the request, else of the unit's type.
base::Result<KnownLimits> limits_for(const ReportRequest& request, const calib::Calibration& calibration) {
  if (request.limits_source) return KnownLimits{request.limits, request.limits_source};
  return limits_of_type(calibration.unit_type);
}

/// The laboratory's references that the fit recorded; null where the stored model does not state them.
json records_json(const std::string& document) {
  const json stored = json::parse(document, nullptr, false);
  const json::json_pointer references("/fit/references");
  return {{"references", stored.contains(references) ? stored[references] : json()}};
}

/// What has become of each reference since: "retired on 2026-05-01 by ann: dropped", or null.
base::Status add_endings(const db::Catalog& catalog, json& records) {
  if (!records["references"].is_array()) return {};
  const auto entries = catalog.references();
  if (!entries) return base::forward_error(entries);
  for (json& reference : records["references"]) {
    reference["since"] = nullptr;
    for (const db::ReferenceRow& row : *entries) {
      if (reference["record_id"] != row.reference.record_id || !(row.withdrawn || row.retired)) continue;
      const db::EndRecord& end = row.withdrawn ? *row.withdrawn : *row.retired;
      reference["since"] = fmt::format("{} on {} by {}: {}", row.withdrawn ? "withdrawn" : "retired",
                                       iso_date(end.utc_s), end.user, end.reason);
    }
  }
  return {};
}

std::set<std::string> campaigns_of(const calib::UnitInput& input) {
  std::set<std::string> campaigns;
  for (const calib::RunInput& run : input.runs) campaigns.insert(run.campaign);
  return campaigns;
}

/// The charts of the check standards that were in the campaigns of the model, and which campaigns these are.
base::Result<json> check_standards_json(const db::Catalog& catalog, const std::set<std::string>& campaigns) {
  const auto charts = check_charts_of(catalog, campaigns);
  if (!charts) return base::forward_error(charts);
  json document = check_document(*charts);
  for (json& unit : document["units"]) {
    for (json& campaign : unit["campaigns"]) campaign.erase("runs");
  }
  document["campaigns"] = campaigns;
  return document;
}

/// What must be told beside what fit and verification say.
base::Result<std::vector<calib::Warning>> station_warnings(const db::Catalog& catalog, const db::UnitRow& unit,
                                                           const db::ModelRow& model, const RunsOfModel& runs,
                                                           const calib::Calibration& calibration) {
  auto warnings = age_warnings(catalog, unit, model);
  if (!warnings) return warnings;
  const auto since = reference_warnings(catalog, calibration.references);
  if (!since) return base::forward_error(since);
  for (const auto& more : {runs.warnings, *since, waiver_warnings(calibration.references)}) {
    warnings->insert(warnings->end(), more.begin(), more.end());
  }
  return warnings;
}

base::Result<calib::UnitInput> input_less_terms(const db::Catalog& catalog, const calib::Calibration& calibration,
                                                const RunsOfModel& runs, RunUse use,
                                                const std::vector<calib::ModelTerm>& terms,
                                                std::vector<calib::Warning>& warnings) {
  auto input = input_of(catalog, calibration, runs, use, warnings);
  if (!input) return input;
  if (auto taken = take_terms_off(catalog, terms, *input, warnings); !taken) return base::forward_error(taken);
  return input;
}

/// Where no verdict holds the summary says why, and what the fresh runs said of the model all the same.
void take_back_verdict(const std::string& why, json& summary) {
  summary["no_verdict"] = why.empty() ? json() : json(why);
  if (why.empty()) return;
  const bool was_judged = summary["verdict"] != "info" && summary["verdict"] != "not_measured";
  summary["sentence"] = fmt::format(
      "No verdict holds: {}.{}", why,
      was_judged ? " For information, of the model as it is: " + summary["sentence"].get<std::string>() : "");
  summary["verdict"] = "info";
}

}  // namespace

base::Result<json> report_document(const db::Catalog& catalog, const ReportRequest& request) {
  const auto unit = find_unit(catalog, request.unit);
  if (!unit) return base::forward_error(unit);
  const auto model = find_model(catalog, request);
  if (!model) return base::forward_error(model);
  const auto calibration = calib::calibration_of(model->document);
  if (!calibration) return base::forward_error(calibration);
  const auto runs = runs_of_model(catalog, *calibration);
  if (!runs) return base::forward_error(runs);
  auto warnings = station_warnings(catalog, *unit, *model, *runs, *calibration);
  if (!warnings) return base::forward_error(warnings);
  const auto terms = calib::model_terms_of(model->document);
  if (!terms) return base::forward_error(terms);
  // Rows are shown as the curve was fitted: less the accepted terms. Fresh runs are judged as `soak verify` does: less
  // what a device corrects.
  const auto fitted = input_less_terms(catalog, *calibration, *runs, RunUse::fitted, *terms, *warnings);
  if (!fitted) return base::forward_error(fitted);
  const auto fresh =
      input_less_terms(catalog, *calibration, *runs, RunUse::fresh, calib::moving_terms(*calibration), *warnings);
  if (!fresh) return base::forward_error(fresh);

  const auto limits = limits_for(request, *calibration);
  if (!limits) return base::forward_error(limits);
  auto sections =
      calib::report_json({model->document, *fitted, *fresh, limits->limits, limits->source, *std::move(warnings)});
  if (!sections) return base::forward_error(sections);
  auto release = release_json(catalog, *model, request.created_utc_s);
  if (!release) return base::forward_error(release);
  const auto why = why_no_verdict(catalog, *unit, *model, *calibration, *release);
  if (!why) return base::forward_error(why);
  take_back_verdict(*why, (*sections)["summary"]);
  auto noise = request.with_noise ? noise_json(catalog, request.unit, model->epoch, request.progress)
                                  : base::Result<json>(no_noise("not asked for"));
  if (!noise) return base::forward_error(noise);
  auto provenance = provenance_json(catalog, *model, *calibration, *runs);
  if (!provenance) return base::forward_error(provenance);
  auto check_standards = check_standards_json(catalog, campaigns_of(*fitted));
  if (!check_standards) return base::forward_error(check_standards);
  json records = records_json(model->document);
  if (auto added = add_endings(catalog, records); !added) return base::forward_error(added);
  (*sections)["terms"] = calib::terms_json(*terms);
  (*sections)["impact"] = impact_with_drives_json(*calibration);
  (*sections)["noise"] = *std::move(noise);
  (*sections)["check_standards"] = *std::move(check_standards);
  (*sections)["records"] = std::move(records);
  (*sections)["release"] = *std::move(release);
  (*sections)["provenance"] = *std::move(provenance);
  return json{{"unit", request.unit},
              {"model", model->version},
              {"created_utc_s", request.created_utc_s},
              {"software", request.software},
              {"sections", *std::move(sections)}};
}

}  // namespace soak::station
