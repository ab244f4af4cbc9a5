// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "calib/judge/control_chart.h"
#include "calib/vocabulary/sensor.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

// ---- check standards ----

std::string unit_of(std::string_view sensor) { return sensor.starts_with("gyro") ? "°/s" : "m/s²"; }

std::string verdict_words(const json& verdict) {
  if (verdict == "out_of_control") return "OUT OF CONTROL";
  return verdict == "in_control" ? "in control" : "not established";
}

html::Cell verdict_cell(const json& verdict) {
  return {.html = verdict_words(verdict),
          .style = verdict == "out_of_control" ? "fail"
                   : verdict == "in_control"   ? "pass"
                                               : ""};
}

/// One sensor over the campaigns; empty where none of them has it.
std::string check_figure(const json& unit, std::string_view sensor, std::size_t ordinal) {
  int campaigns = 0;
  int out = 0;
  for (const json& campaign : unit["campaigns"]) {
    const json& found = member(campaign["sensors"], sensor);
    campaigns += found.is_null() ? 0 : 1;
    out += member(found, "verdict") == "out_of_control" ? 1 : 0;
  }
  if (campaigns == 0) return {};
  return figure(
      "check", sensor,
      {fmt::format("{} of {}", sensor, unit["unit"].get<std::string>()),
       fmt::format("{} campaigns, {} of them out of control; those of this model are ringed.", campaigns, out)},
      fmt::format(" data-unit=\"{}\"", ordinal));
}

/// Decimals that show two digits of the scatter of campaigns, or of the point's own error where that is not known.
int decimals_of(const json& found) {
  const json& limits = found["limits"];
  const double spread = limits.is_null() ? found["bias_se"].get<double>() : limits["sigma"].get<double>();
  return spread > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(spread))), 0, 9) : 6;
}

html::Cell range_cell(const json& limits, int decimals) {
  if (limits.is_null()) return {.html = "–"};
  return html::html_cell(html::number(limits["lower"].get<double>(), decimals) + " to " +
                             html::number(limits["upper"].get<double>(), decimals),
                         true);
}

void add_rows(html::Table& table, const json& campaign) {
  for (const std::string_view sensor : calib::kSensorNames) {
    const json& found = member(campaign["sensors"], sensor);
    if (found.is_null()) continue;
    const int decimals = decimals_of(found);
    const json& eight = found["last_eight"];
    const json& limits = found["limits"];
    table.row({html::row_heading(campaign["campaign"].get<std::string>()), html::text_cell(sensor),
               html::text_cell(unit_of(sensor)),
               html::html_cell(html::number(found["bias"].get<double>(), decimals), true), range_cell(limits, decimals),
               html::text_cell(limits.is_null() ? "–" : std::to_string(limits["campaigns"].get<int>())),
               html::html_cell(eight.is_null() ? "–" : html::number(eight["mean"].get<double>(), decimals), true),
               range_cell(eight, decimals), verdict_cell(found["verdict"])});
  }
}

std::string table_of(const json& unit, const json& check_standards) {
  html::Table table("The campaigns of this model on the charts",
                    {"campaign", "sensor", "unit", "bias", "limits", "from campaigns", "mean of the last eight",
                     "its limits", "verdict"});
  for (const json& campaign : unit["campaigns"]) {
    if (is_of_model(check_standards, campaign)) add_rows(table, campaign);
  }
  return table.html();
}

std::string sentence_of(const json& unit, const json& check_standards) {
  std::string html;
  for (const json& campaign : unit["campaigns"]) {
    if (!is_of_model(check_standards, campaign)) continue;
    html += fmt::format("<p>Campaign {}: <b>{}</b>{}</p>\n", html::text_of(campaign, "campaign"),
                        verdict_words(campaign["verdict"]), campaign["simulated"].get<bool>() ? ", SIMULATED" : "");
  }
  return html;
}

std::string basis() {
  return fmt::format(
      "<p class=\"soft\">The unit above is measured in every campaign and never deployed: a change in its results is a "
      "change of the station. Its biases are converted to one temperature. Limits: prediction limits of Student's t "
      "from mean and standard deviation of earlier campaigns in control, {} at least, the first {}; by chance at most "
      "{:g} % of campaigns in which nothing has changed are out of control. Fewer earlier campaigns: not established, "
      "nothing is judged.</p>\n",
      calib::kFewestForLimits, calib::kMostForLimits, 100.0 * calib::kFalseAlarmPerCampaign);
}

// ---- runs ----

std::string_view use_words(std::string_view use) {
  if (use == "fitted") return "fitted";
  if (use == "fresh") return "verification, in no fit";
  if (use == "not_used") return "not in this model";
  if (use == "diagnosis") return "diagnosis, never fitted";
  if (use == "voided") return "void";
  return "not sealed";
}

std::string recorded_text(const json& run) {
  std::string text = html::text_of(run, "source");
  if (run["clock_rate"] != 1.0) text += fmt::format(", clock rate {}", html::number(run["clock_rate"]));
  if (run["simulated"].get<bool>()) text += ", SIMULATED";
  return text;
}

std::string site_text(const json& run) {
  std::string text =
      fmt::format("{} m/s² ({})", html::number(run["gravity_mps2"].get<double>(), 5), html::text_of(run, "gravity"));
  if (run["latitude_deg"].is_number()) {
    text += fmt::format(", latitude {}°", html::number(run["latitude_deg"].get<double>(), 2));
  }
  return text;
}

std::string runs_table(const json& runs) {
  html::Table table("Runs of this unit in this epoch", {"run", "campaign", "procedure", "use", "stored", "length",
                                                        "how recorded", "gravity", "content hash (SHA-256)"});
  for (const json& run : runs) {
    const bool withdrawn = run["use"] == "fitted" && !run["voids"].empty() && run["voids"][0]["what"] == "run";
    table.row({html::row_heading(run["label"].get<std::string>()),
               html::html_cell(html::text_of(run, "campaign")),
               html::html_cell(html::text_of(run, "procedure")),
               html::text_cell(std::string(use_words(run["use"].get<std::string>())) + (withdrawn ? ", now void" : "")),
               {.html = html::date_time(run["created_utc_s"]), .style = "nowrap"},
               {.html = html::duration(run["duration_s"]), .style = "nowrap"},
               html::html_cell(recorded_text(run)),
               html::html_cell(site_text(run)),
               html::html_cell("<code>" + html::text_of(run, "content_sha256") + "</code>")});
  }
  return table.html();
}

std::string voids_table(const json& runs) {
  html::Table table("Withdrawn, with reason", {"run", "what", "reason", "by", "when"});
  bool any = false;
  for (const json& run : runs) {
    for (const json& entry : run["voids"]) {
      any = true;
      const bool whole = entry["what"] == "run";
      table.row(
          {html::row_heading(run["label"].get<std::string>()),
           html::text_cell(whole ? "the whole run" : fmt::format("{} records on parts", entry["records"].get<int>())),
           html::html_cell(html::text_of(entry, "reason")),
           html::html_cell(html::text_of(entry, "user")),
           {.html = html::date_time(entry["utc_s"]), .style = "nowrap"}});
    }
  }
  return any ? table.html() : "<p>No part of these runs is withdrawn.</p>\n";
}

}  // namespace

bool is_of_model(const json& check_standards, const json& campaign) {
  const json& names = check_standards["campaigns"];
  return std::ranges::find(names, campaign["campaign"]) != names.end();
}

std::string check_part(const json& check_standards) {
  std::string html = "<section id=\"check\"><h2>Check standards</h2>\n";
  const json& units = check_standards["units"];
  if (units.empty()) {
    return html +
           "<p>No check standard was in the campaigns of this model: changes of the station would not "
           "show.</p></section>\n";
  }
  std::size_t ordinal = 0;
  for (const json& unit : units) {
    html += fmt::format("<h3>Check standard {}{}</h3>\n", html::text_of(unit, "unit"),
                        unit["ended"].get<bool>() ? " (ended)" : "");
    html += sentence_of(unit, check_standards) + table_of(unit, check_standards) + "<div class=\"figures\">\n";
    for (const std::string_view sensor : calib::kSensorNames) html += check_figure(unit, sensor, ordinal);
    html += "</div>\n";
    ++ordinal;
  }
  return html + basis() + "</section>\n";
}

std::string provenance_part(const json& document) {
  const json& sections = document["sections"];
  const json& provenance = sections["provenance"];
  std::string html = "<section id=\"provenance\"><h2>Where it comes from</h2>\n";
  html += runs_table(provenance["runs"]) + voids_table(provenance["runs"]);
  html += html::facts({{"Model document (SHA-256)", "<code>" + html::text_of(provenance, "model_sha256") + "</code>"},
                       {"Fitted", html::date_time(sections["summary"]["model_created_utc_s"])},
                       {"Page made by", html::text_of(document, "software")},
                       {"Page made", html::date_time(document["created_utc_s"])}});
  return html + "</section>\n";
}

}  // namespace soak::station
