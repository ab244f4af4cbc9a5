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

#include "calib/curve/families.h"
#include "calib/vocabulary/sensor.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

// With more the certificate would not stay on one page.
constexpr std::size_t kMostWarnings = 6;      ///< of those that ask for something
constexpr std::size_t kMostAsides = 3;        ///< of those that ask for nothing
constexpr std::size_t kLongestWarning = 160;  ///< bytes of a text
constexpr std::size_t kLongestAside = 60;

constexpr std::string_view kSimulatedMark =
    "<p class=\"simulated-mark\">SIMULATED DATA: not measured on a real unit</p>\n";

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

/// A file without a curve of the scale says nothing of it.
html::Cell scale_verdict_cell(const json& sensor) {
  if (!member(sensor["fit"], "scale_deployed").is_string()) return {.html = "scale not known", .style = "nowrap"};
  return verdict_cell(member(member(sensor["verification"], "scale"), "verdict"), !sensor["scale_limit_ppm"].is_null());
}

/// "± 0.012 (k = 2.1)": the largest U of an error.
html::Cell uncertainty_cell(const json& sensor) {
  const json& bias = member(sensor["verification"], "bias");
  const json& guard = member(bias, "guard");
  if (!guard.is_number()) return html::number_cell(json());
  const json& factor = member(bias, "guard_factor");
  const std::string k = factor.is_number() ? fmt::format(" (k = {:.2f})", factor.get<double>()) : "";
  return html::html_cell("± " + html::number(guard) + k, true);
}

/// `holds`: there may be a verdict.
std::string verdict_table(const json& sensors, bool holds) {
  const html::Cell none{.html = "not judged", .style = "nowrap"};
  html::Table table("Verdict, sensor by sensor",
                    {"sensor", "bias verdict", "scale verdict", "worst fresh error of bias", "largest U, 95 %",
                     "limit of bias", "95 % of fresh power-ons", "range, °C"},
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
         holds ? bias_verdict_cell(sensor) : none,
         holds ? scale_verdict_cell(sensor) : none,
         html::number_cell(member(member(sensor["verification"], "bias"), "worst_abs")),
         uncertainty_cell(sensor),
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

/// As much of a text as the certificate has room for.
std::string cut(const std::string& text, std::size_t longest) {
  if (text.size() <= longest) return text;
  std::size_t end = longest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // inside a character
  return text.substr(0, end) + "…";
}

std::string remedy_line(const json& warning) {
  const std::string remedy = warning.value("remedy", "");
  if (remedy.empty()) return {};
  return fmt::format("<span class=\"do\">{}{}</span>", asks(warning) ? "What to do: " : "", html::said(remedy));
}

std::string warning_list(const std::vector<json>& warnings, std::size_t longest) {
  std::string html = "<ul class=\"warnings\">\n";
  for (const json& warning : warnings) {
    html +=
        fmt::format("<li class=\"{}\"><span class=\"who\">{}</span>{} <code>{}</code>{}</li>\n",
                    html::escaped(warning.value("urgency", "act")), who(warning),
                    html::said(cut(warning["text"], longest)), html::text_of(warning, "code"), remedy_line(warning));
  }
  return html + "</ul>\n";
}

bool is_baseline(const json& warning) { return warning["code"] == "baseline_deployed"; }

/// Those that ask for nothing, the curves in the file that are no ANFIS left out.
std::vector<json> asides_of(const json& summary) {
  std::vector<json> list;
  std::ranges::copy_if(summary["warnings"], std::back_inserter(list),
                       [](const json& warning) { return !asks(warning) && !is_baseline(warning); });
  return list;
}

/// "5 polynomial, 3 spline": the curves, of bias or scale, that were taken instead of an ANFIS, by family. `judged`: on
/// held-out runs, else by the expected error of few runs. Empty where there are none.
std::string families_text(const json& summary, bool judged) {
  std::map<std::string, std::size_t> curves;
  for (const json& warning : summary["warnings"]) {
    if (!is_baseline(warning)) continue;
    const std::string text = warning["text"];
    if ((text.find(calib::kFewRunsAreNoJudge) == std::string::npos) != judged) continue;
    const std::size_t sensors = warning["sensors"].size();
    curves[text.find(": spline ") != std::string::npos ? "spline" : "polynomial"] += std::max<std::size_t>(sensors, 1);
  }
  std::vector<std::string> parts;
  for (const auto& [family, count] : curves) parts.push_back(fmt::format("{} {}", count, family));
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// What asks for nothing, in one line; empty where there is nothing of the kind.
std::string nothing_to_do(const json& summary) {
  std::vector<std::string> parts;
  if (const std::string judged = families_text(summary, true); !judged.empty()) {
    parts.push_back("better than the ANFIS and in the file: " + judged);
  }
  if (const std::string few = families_text(summary, false); !few.empty()) {
    parts.push_back(fmt::format("in the file for the least expected error, {}: {}", calib::kFewRunsAreNoJudge, few));
  }
  const std::vector<json> asides = asides_of(summary);
  for (std::size_t i = 0; i < std::min(asides.size(), kMostAsides); ++i) {
    parts.push_back(who(asides[i]) + html::said(cut(asides[i]["text"], kLongestAside)));
  }
  if (asides.size() > kMostAsides) parts.push_back(fmt::format("{} more", asides.size() - kMostAsides));
  if (parts.empty()) return {};
  return fmt::format("<p class=\"soft\">Nothing to do: {}.</p>\n", fmt::join(parts, "; "));
}

/// Whether the one line says all that there is to an aside.
bool has_more(const json& aside, std::size_t ordinal) {
  return ordinal >= kMostAsides || aside["text"].get_ref<const std::string&>().size() > kLongestAside ||
         aside.value("remedy", "") != "No action needed.";
}

/// The warnings of which the certificate has not all.
std::vector<json> left_over(const json& summary) {
  std::vector<json> list;
  const std::vector<json> asking = those_that_ask(summary);
  for (std::size_t i = 0; i < asking.size(); ++i) {
    const bool is_cut = asking[i]["text"].get_ref<const std::string&>().size() > kLongestWarning;
    if (i >= kMostWarnings || is_cut) list.push_back(asking[i]);
  }
  const std::vector<json> asides = asides_of(summary);
  for (std::size_t i = 0; i < asides.size(); ++i) {
    if (has_more(asides[i], i)) list.push_back(asides[i]);
  }
  return list;
}

/// The warnings of the certificate, each cut to a few lines.
std::string warnings_part(const json& summary, bool alone_on_page) {
  std::vector<json> warnings = those_that_ask(summary);
  const std::size_t more = warnings.size() > kMostWarnings ? warnings.size() - kMostWarnings : 0;
  warnings.resize(warnings.size() - more);
  std::string html = warnings.empty() ? "" : warning_list(warnings, kLongestWarning);
  html += nothing_to_do(summary);
  if (left_over(summary).empty()) return html;
  return html +
         fmt::format("<p class=\"soft\">{}: {}.</p>\n",
                     more > 0 ? fmt::format("And {} more", more) : std::string("More on these"),
                     alone_on_page ? "see <a href=\"#warnings\">all warnings</a>" : "see the report of the unit");
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
      "<section id=\"{0}\" class=\"certificate\">\n<p class=\"brand\">Calibration certificate</p>\n<{1}>Unit "
      "{2}</{1}>\n",
      id, heading, html::text_of(document, "unit"));
  const bool alone_on_page = heading == "h1";
  // Of a page of its own the frame says it.
  if (!alone_on_page && summary["simulated"].get<bool>()) html += kSimulatedMark;
  html += verdict_line(summary["verdict"], summary["sentence"]);
  html += certificate_facts(document);
  html += verdict_table(sections["sensors"], member(summary, "no_verdict").is_null());
  html +=
      "<p class=\"soft\">A limit is judged on fresh runs that no fit has seen: error and expanded uncertainty U = k u "
      "(95 %) together must be within it (JCGM 106). Where the scale of a sensor is not known nothing is said of it. "
      "Without a limit nothing passes.</p>\n";
  html += basis_facts(document);
  return html + warnings_part(summary, alone_on_page) + signature_part() + "</section>\n";
}

std::string more_warnings_part(const json& summary) {
  const std::vector<json> warnings = left_over(summary);
  if (warnings.empty()) return {};
  return "<section id=\"warnings\"><h2>More warnings</h2>\n" + warning_list(warnings, std::string::npos) +
         "</section>\n";
}

}  // namespace soak::station
