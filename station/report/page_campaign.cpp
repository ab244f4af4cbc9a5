// SPDX-License-Identifier: Apache-2.0
// The report of a campaign: an overview, then a page for each unit.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "station/report/html.h"
#include "station/report/page.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::string_view kNoReport = "no report";

/// Verdicts, the worst first, with what the overview calls them.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kVerdicts = {{{"fail", "fail"},
                                                                                     {"marginal", "marginal"},
                                                                                     {"not_measured", "not measured"},
                                                                                     {"info", "not judged"},
                                                                                     {"", kNoReport},
                                                                                     {"pass", "pass"}}};

std::string verdict_of_line(const json& line) {
  return line["verdict"].is_string() ? line["verdict"].get<std::string>() : std::string();
}

std::string_view word_for(const std::string& verdict) {
  return std::ranges::find(kVerdicts, verdict, &std::pair<std::string_view, std::string_view>::first)->second;
}

/// The worst verdict of all units, and how many have which.
std::string units_verdict(const json& units) {
  std::string worst;
  std::vector<std::string> counts;
  for (const auto& [verdict, word] : kVerdicts) {
    const auto count = std::ranges::count_if(units, [&](const json& line) { return verdict_of_line(line) == verdict; });
    if (count == 0) continue;
    if (counts.empty()) worst = verdict.empty() ? "no_report" : verdict;
    counts.push_back(fmt::format("{} {}", count, word));
  }
  return verdict_line(
      worst, fmt::format("{} unit{}: {}.", units.size(), units.size() == 1 ? "" : "s", fmt::join(counts, ", ")));
}

std::string section_id(std::size_t ordinal) { return fmt::format("unit-{}", ordinal + 1); }

std::string_view data_word(const json& line) {
  if (!line["simulated"].is_boolean()) return "–";
  return line["simulated"].get<bool>() ? "<b>SIMULATED</b>" : "measured";
}

std::string units_table(const json& units) {
  html::Table table("Units of the campaign", {"unit", "verdict", "data", "model", "fitted", "what it says"},
                    html::Narrow::stacks);
  for (std::size_t i = 0; i < units.size(); ++i) {
    const json& line = units[i];
    const std::string serial = html::text_of(line, "unit");
    const std::string verdict = verdict_of_line(line);
    const bool has_page = line["trouble"].is_null();
    table.row(
        {{.html = has_page ? fmt::format("<a href=\"#{}\">{}</a>", section_id(i), serial) : serial, .heading = true},
         {.html = std::string(word_for(verdict)), .style = "nowrap " + verdict},
         {.html = std::string(data_word(line)), .style = "nowrap"},
         html::html_cell(html::text_of(line, "model"), true),
         {.html = html::date_time(line["fitted_utc_s"]), .style = "nowrap"},
         html::html_cell(html::text_of(line, has_page ? "sentence" : "trouble"))});
  }
  return table.html();
}

}  // namespace

std::string campaign_page(const CampaignReport& report) {
  const json& document = report.document;
  const json& units = document["units"];
  const std::string campaign = document["campaign"];
  std::string body = fmt::format(
      "<section id=\"overview\" class=\"certificate\">\n<p class=\"brand\">Soak calibration report</p>\n<h1>Campaign "
      "{}</h1>\n",
      html::escaped(campaign));
  body += units_verdict(units) + units_table(units);
  body +=
      "<p class=\"soft\">Each unit is judged by its newest model, as in its own report, which has the curves and where "
      "every number comes from.</p></section>\n";
  for (std::size_t i = 0; i < report.units.size(); ++i) {
    if (!report.units[i].is_null()) body += certificate_part(report.units[i], section_id(i), "h2");
  }
  // The bar and the watermark would be on the certificates of real units too: each certificate has its own mark.
  const Frame frame = {"Calibration report, campaign " + campaign, document["software"].get<std::string>(),
                       document["created_utc_s"].get<double>(), false, "Calibration report, campaign " + campaign};
  return page_frame(frame, body, json::object());
}

}  // namespace soak::station
