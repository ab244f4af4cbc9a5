// SPDX-License-Identifier: Apache-2.0
#include "station/report/campaign_report.h"

#include <fmt/format.h>

#include <set>
#include <utility>

namespace soak::station {
namespace {

using nlohmann::json;

base::Result<std::set<std::string>> units_of(const db::Catalog& catalog, const std::string& campaign) {
  const auto runs = catalog.runs({.unit = {}, .campaign = campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  if (runs->empty()) {
    return base::bad_input(
        fmt::format("there is no campaign '{}'; 'soak runs list' shows those that there are", campaign), "--campaign");
  }
  std::set<std::string> units;
  for (const db::RunRow& run : *runs) {
    if (!run.voided && run.purpose != "diagnosis") units.insert(run.unit);
  }
  if (units.empty()) {
    return base::bad_input(fmt::format("campaign '{}' has no run that counts: all are void or pre-flights", campaign),
                           "--campaign");
  }
  return units;
}

/// A line of the overview; `report` is null where `trouble` says why.
json unit_line(const std::string& serial, const json& report, const std::string& trouble) {
  const json summary = report.is_null() ? json() : report["sections"]["summary"];
  const auto of_summary = [&](const char* key) { return summary.is_null() ? json() : summary[key]; };
  return {{"unit", serial},
          {"model", report.is_null() ? json() : report["model"]},
          {"fitted_utc_s", of_summary("model_created_utc_s")},
          {"simulated", of_summary("simulated")},
          {"verdict", of_summary("verdict")},
          {"sentence", of_summary("sentence")},
          {"trouble", trouble.empty() ? json() : json(trouble)}};
}

}  // namespace

base::Result<CampaignReport> campaign_report(const db::Catalog& catalog, const std::string& campaign,
                                             const ReportRequest& request) {
  const auto units = units_of(catalog, campaign);
  if (!units) return base::forward_error(units);
  CampaignReport all;
  all.document = {{"campaign", campaign},
                  {"created_utc_s", request.created_utc_s},
                  {"software", request.software},
                  {"units", json::array()}};
  ReportRequest of_unit = request;
  of_unit.model.reset();
  of_unit.with_noise = false;
  for (const std::string& serial : *units) {
    if (!request.progress(static_cast<double>(all.units.size()) / static_cast<double>(units->size()))) {
      return base::fail(base::ErrorKind::internal, "interrupted; no report was written");
    }
    of_unit.unit = serial;
    const auto model = catalog.model(serial);
    if (!model) return base::forward_error(model);
    auto report = report_document(catalog, of_unit);
    // A unit may wait for its fit; whatever else is wrong would leave a gap in the page that nobody asked for.
    if (!report && *model) return base::forward_error(report);
    const std::string why_not = report ? "" : report.error().message;
    all.units.push_back(report ? *std::move(report) : json());
    all.document["units"].push_back(unit_line(serial, all.units.back(), why_not));
  }
  return all;
}

}  // namespace soak::station
