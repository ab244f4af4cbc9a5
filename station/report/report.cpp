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
#include "calib/model/document_parts.h"
#include "station/io/data_folder.h"
#include "station/io/output.h"
#include "station/io/text.h"
#include "station/nav/free_inertial.h"
#include "station/records/check_standard.h"
#include "station/report/release_part.h"
#include "station/report/rows_of_model.h"
#include "station/runs/rest_record.h"
#include "station/runs/still_segment.h"

namespace soak::station {
namespace {

using nlohmann::json;

// ---- noise ----

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
  if (!*longest) return no_noise(kNothingAtRest);
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
  return json{{"segment", still_segment_json(**longest)}, {"sensors", std::move(sensors)}, {"reason", json()}};
}

// ---- records ----

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
  const auto rows = rows_of_model(
      catalog,
      {.unit = request.unit, .model = request.model, .limits = request.limits, .source = request.limits_source});
  if (!rows) return base::forward_error(rows);
  auto sections = calib::report_json(rows->input);
  if (!sections) return base::forward_error(sections);
  const auto unit = find_unit(catalog, request.unit);
  if (!unit) return base::forward_error(unit);
  auto release = release_json(catalog, rows->model, request.created_utc_s);
  if (!release) return base::forward_error(release);
  const auto why = why_no_verdict(catalog, *unit, rows->model, rows->calibration, *release);
  if (!why) return base::forward_error(why);
  take_back_verdict(*why, (*sections)["summary"]);
  auto noise = request.with_noise ? noise_json(catalog, request.unit, rows->model.epoch, request.progress)
                                  : base::Result<json>(no_noise("not asked for"));
  if (!noise) return base::forward_error(noise);
  auto provenance = provenance_json(catalog, rows->model, rows->calibration, rows->runs);
  if (!provenance) return base::forward_error(provenance);
  auto check_standards = check_standards_json(catalog, campaigns_of(rows->input.fitted));
  if (!check_standards) return base::forward_error(check_standards);
  json records = records_json(rows->model.document);
  if (auto added = add_endings(catalog, records); !added) return base::forward_error(added);
  (*sections)["terms"] = calib::terms_json(rows->terms);
  (*sections)["impact"] = impact_with_drives_json(rows->calibration);
  (*sections)["noise"] = *std::move(noise);
  (*sections)["check_standards"] = *std::move(check_standards);
  (*sections)["records"] = std::move(records);
  (*sections)["release"] = *std::move(release);
  (*sections)["provenance"] = *std::move(provenance);
  return json{{"unit", request.unit},
              {"model", rows->model.version},
              {"created_utc_s", request.created_utc_s},
              {"software", request.software},
              {"sections", *std::move(sections)}};
}

}  // namespace soak::station
