// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/report/report.h"

namespace soak::station {

/// What the report of a campaign holds.
struct CampaignReport {
  nlohmann::json document;  ///< docs/schema/report-campaign.schema.json but for `file`, `bytes` and `sha256`
  /// One for each of the document's `units`: what report_document() says of it, null where it says nothing.
  std::vector<nlohmann::json> units;
};

/// The newest models of all units of which the campaign has runs that count (no pre-flight, not void), judged as in
/// their own reports, without an analysis of the noise. A unit that cannot be reported, as it has no model, is listed
/// with the reason. Of `request` count limits, time, software and progress. Refuses a campaign that is not known or has
/// no such run; a run file that is missing is damage.
[[nodiscard]] base::Result<CampaignReport> campaign_report(const db::Catalog& catalog, const std::string& campaign,
                                                           const ReportRequest& request);

}  // namespace soak::station
