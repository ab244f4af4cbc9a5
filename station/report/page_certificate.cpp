// SPDX-License-Identifier: Apache-2.0
// The first page: what is decided about a unit, from what, and what speaks against it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

/// Of those that ask for something; with more the certificate would not stay on one page.
constexpr std::size_t kMostWarnings = 6;

std::string verdict_word(const std::string& verdict) {
  std::string word = verdict == "info" ? "not judged" : verdict;
  std::ranges::replace(word, '_', ' ');
  std::ranges::transform(word, word.begin(), [](char c) { return c >= 'a' && c <= 'z' ? char(c - 32) : c; });
  return html::escaped(word);
}

// ---- verdicts ----

/// `verdict` null: no fresh run said anything; `limited`: there is a limit to be judged by.
html::Cell verdict_cell(const json& verdict, bool limited) {
  if (!verdict.is_string() || verdict == "not_measured")
    return {.html = limited ? "not measured" : "no limit", .style = "nowrap"};
  if (verdict == "info") return {.html = "no limit", .style = "nowrap"};
  return {.html = html::escaped(verdict.get<std::string>()), .style = verdict.get<std::string>()};
}

html::Cell bias_verdict_cell(const json& sensor) {
  return verdict_cell(member(member(sensor["verification"], "bias"), "verdict"), !sensor["limit"].is_null());
}

/// The worst of bias and scale.
html::Cell sensor_verdict_cell(const json& sensor) {
  const bool limited = !sensor["limit"].is_null() || !sensor["scale_limit_ppm"].is_null();
  return verdict_cell(member(sensor["verification"], "verdict"), limited);
}

std::string verdict_table(const json& sensors) {
  html::Table table("Verdict, sensor by sensor",
                    {"sensor", "on its bias", "on the sensor", "worst fresh error of bias", "limit of bias",
                     "95 % of fresh power-ons", "range, °C"},
                    html::Narrow::stacks);
  for (const std::string_view name : calib::kSensorNames) {
    const json& sensor = member(sensors, name);
    if (sensor.is_null()) continue;
    const json& fit = sensor["fit"];
    const std::string range =
        html::number(fit["temp_min_c"].get<double>(), 1) + " to " + html::number(fit["temp_max_c"].get<double>(), 1);
    const json pi95 = largest(fit["curve"], "pi95");
    table.row(
        {{.html = html::escaped(name) + ", " + html::unit_text(sensor["unit"].get<std::string>()), .heading = true},
         bias_verdict_cell(sensor),
         sensor_verdict_cell(sensor),
         html::number_cell(member(member(sensor["verification"], "bias"), "worst_abs")),
         html::number_cell(sensor["limit"]),
         html::html_cell(pi95.is_null() ? "–" : "± " + html::number(pi95), true),
         html::html_cell(range, true)});
  }
  return table.html();
}

// ---- warnings ----

bool asks(const json& warning) { return warning.value("urgency", "act") != "none"; }

std::vector<json> those_that_ask(const json& summary) {
  std::vector<json> list;
  std::ranges::copy_if(summary["warnings"], std::back_inserter(list), asks);
  return list;
}

std::string who(const json& warning) {
  const auto sensors = warning["sensors"].get<std::vector<std::string>>();
  if (sensors.empty()) return {};
  const std::string text = warning["text"];
  if (sensors.size() == 1 && text.starts_with(sensors.front())) return {};
  return html::escaped(sensors.size() == 6 ? "all sensors" : fmt::format("{}", fmt::join(sensors, ", "))) + ": ";
}

std::string warning_list(const std::vector<json>& warnings) {
  std::string html = "<ul class=\"warnings\">\n";
  for (const json& warning : warnings) {
    const std::string remedy = warning.value("remedy", "");
    html += fmt::format("<li class=\"{}\"><span class=\"who\">{}</span>{} <code>{}</code>{}</li>\n",
                        html::escaped(warning.value("urgency", "act")), who(warning), html::text_of(warning, "text"),
                        html::text_of(warning, "code"),
                        remedy.empty() ? "" : "<span class=\"do\">What to do: " + html::escaped(remedy) + "</span>");
  }
  return html + "</ul>\n";
}

/// "5 polynomial, 3 spline": the curves in the file that are no ANFIS, by family.
std::string families_text(const json& sensors) {
  std::map<std::string, int> curves;
  for (const json& sensor : sensors) {
    for (const char* key : {"deployed", "scale_deployed"}) {
      const std::string family = member(sensor["fit"], key).is_string() ? sensor["fit"][key].get<std::string>() : "";
      if (family.starts_with("poly")) ++curves["polynomial"];
      if (family == "spline") ++curves["spline"];
    }
  }
  std::vector<std::string> parts;
  for (const auto& [family, count] : curves) parts.push_back(fmt::format("{} {}", count, family));
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// What asks for nothing, in one line; empty where there is nothing of the kind.
std::string nothing_to_do(const json& sections) {
  std::vector<std::string> parts;
  bool families_told = false;
  for (const json& warning : sections["summary"]["warnings"]) {
    if (asks(warning)) continue;
    if (warning["code"] != "baseline_deployed") {
      parts.push_back(who(warning) + html::text_of(warning, "text"));
    } else if (!std::exchange(families_told, true)) {
      parts.insert(parts.begin(), "better than the ANFIS and in the file: " + families_text(sections["sensors"]));
    }
  }
  if (parts.empty()) return {};
  return fmt::format("<p class=\"soft\">Nothing to do: {}.</p>\n", fmt::join(parts, "; "));
}

// ---- what it rests on ----

/// "R01, R02, R03 of campaign spring" of the runs with that use.
std::string runs_text(const json& runs, std::string_view use) {
  std::map<std::string, std::vector<std::string>> labels;
  for (const json& run : runs) {
    if (run["use"] == use) labels[run["campaign"]].push_back(run["label"]);
  }
  std::vector<std::string> parts;
  for (const auto& [campaign, names] : labels) {
    parts.push_back(names.size() > 6 ? fmt::format("{} runs of campaign {}", names.size(), campaign)
                                     : fmt::format("{} of campaign {}", fmt::join(names, ", "), campaign));
  }
  return parts.empty() ? "none" : html::escaped(fmt::format("{}", fmt::join(parts, "; ")));
}

std::string references_text(const json& references) {
  if (!references.is_array()) return "not stated";
  std::vector<std::string> parts;
  for (const json& reference : references) {
    parts.push_back(fmt::format("{} {} ({})", html::text_of(reference, "kind"), html::text_of(reference, "name"),
                                html::text_of(reference, "certificate")));
  }
  return parts.empty() ? "none: nothing here is traceable to a certificate" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string basis_facts(const json& document) {
  const json& sections = document["sections"];
  const json& summary = sections["summary"];
  return html::facts(
      {{"Type", html::text_of(summary, "unit_type")},
       {"Epoch", html::text_of(summary, "epoch")},
       {"Model version", html::text_of(document, "model")},
       {"Fitted", html::date_time(summary["model_created_utc_s"])},
       {"Data", summary["simulated"].get<bool>() ? "SIMULATED" : "measured"},
       {"Limits", summary["limits"].is_null() ? "none" : html::text_of(summary, "limits")},
       {"Gravity", fmt::format("{} m/s² ({})", html::number(summary["gravity_mps2"].get<double>(), 5),
                               html::text_of(summary, "gravity"))},
       {"Calibrated from", runs_text(sections["provenance"]["runs"], "fitted")},
       {"Verified with", runs_text(sections["provenance"]["runs"], "fresh")},
       {"References", references_text(sections["records"]["references"])},
       {"Model document (SHA-256)", "<code>" + html::text_of(sections["provenance"], "model_sha256") + "</code>"}});
}

}  // namespace

std::string verdict_line(const std::string& verdict, const std::string& sentence) {
  return fmt::format("<p class=\"verdict {}\"><b>{}</b>{}</p>\n", html::escaped(verdict), verdict_word(verdict),
                     html::escaped(sentence));
}

json largest(const json& curve, const char* key) {
  double value = 0.0;
  for (const json& point : curve) {
    if (!point[key].is_number()) return {};
    value = std::max(value, point[key].get<double>());
  }
  return value;
}

std::string certificate_part(const json& document, std::string_view id, std::string_view heading) {
  const json& sections = document["sections"];
  const json& summary = sections["summary"];
  std::string html = fmt::format(
      "<section id=\"{0}\" class=\"certificate\">\n<p class=\"brand\">Soak calibration report</p>\n<{1}>Unit "
      "{2}</{1}>\n",
      id, heading, html::text_of(document, "unit"));
  html += verdict_line(summary["verdict"], summary["sentence"]);
  html += verdict_table(sections["sensors"]);
  html +=
      "<p class=\"soft\">A limit is judged on fresh runs that no fit has seen, with a guard band of the 95 % "
      "uncertainty of each estimate (JCGM 106). The verdict on the sensor is the worst of bias and scale. Without a "
      "limit nothing passes.</p>\n";
  html += basis_facts(document);
  std::vector<json> warnings = those_that_ask(summary);
  const std::size_t more = warnings.size() > kMostWarnings ? warnings.size() - kMostWarnings : 0;
  warnings.resize(warnings.size() - more);
  if (!warnings.empty()) html += warning_list(warnings);
  if (more > 0) {
    html += fmt::format("<p class=\"soft\">And {} more: {}.</p>\n", more,
                        heading == "h1" ? "<a href=\"#warnings\">warnings</a>" : "see the report of the unit");
  }
  return html + nothing_to_do(sections) + "</section>\n";
}

std::string more_warnings_part(const json& summary) {
  std::vector<json> warnings = those_that_ask(summary);
  if (warnings.size() <= kMostWarnings) return {};
  warnings.erase(warnings.begin(), warnings.begin() + kMostWarnings);
  return "<section id=\"warnings\"><h2>More warnings</h2>\n" + warning_list(warnings) + "</section>\n";
}

}  // namespace soak::station
