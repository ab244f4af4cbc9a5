// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "nav/outages/outage_runner.h"
#include "station/gap/gap_comparison.h"
#include "station/report/campaign_report.h"
#include "station/report/gap_words.h"

namespace soak::station {

/// A unit's report as one HTML page that needs nothing else, its first printed page a certificate: no script, no font,
/// no picture from elsewhere; a content security policy forbids them. Its figures are drawn by its own script from data
/// in it. Texts of the document are escaped. Numbers stand in `<data value="...">` with all their digits. `document` is
/// that of report_document().
[[nodiscard]] std::string report_page(const nlohmann::json& document);

/// The report of a campaign as one HTML page that needs nothing else: all units with their verdicts, then for each of
/// them the certificate of its own report, each on a printed page.
[[nodiscard]] std::string campaign_page(const CampaignReport& report);

/// The gap before and after as one HTML page that needs nothing else: per sensor what was read beyond the simulation,
/// over temperature, with a table of figures and what was accepted. `sentences`: what stands first. `software`: name
/// and version of this program.
[[nodiscard]] std::string gap_page(const GapComparison& comparison, const ThreeSentences& sentences,
                                   const std::string& software, double created_utc_s);

/// A comparison of pipelines on outages (comparison_json(), of these results) as one HTML page that needs nothing else:
/// their table, the mean error over time, and of the first 24 outages the track and the error over time, each line of
/// at most 300 points. `about`: a sentence on what was compared, or nothing.
[[nodiscard]] std::string outages_page(const nlohmann::json& comparison, std::span<const nav::OutageResult> results,
                                       const std::string& about, const std::string& software, double created_utc_s);

}  // namespace soak::station
