// SPDX-License-Identifier: Apache-2.0
#include "station/report/page.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "station/http/web_files.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

// ---- frame ----

constexpr std::string_view kSimulatedBar =
    "<div class=\"simulated-bar\" role=\"note\">SIMULATED DATA: not measured on a real unit</div>\n"
    "<div class=\"watermark\" aria-hidden=\"true\">SIMULATED</div>\n";

constexpr std::string_view kWithoutScript =
    "<noscript><p class=\"soft\">The charts on this page need its script, which is not running; tables and text do "
    "not.</p></noscript>\n";

// ---- overview ----

/// Held-out errors of the deployed family.
const json& deployed_error(const json& fit, const char* of_anfis, const char* of_baseline) {
  const std::string deployed = fit["deployed"];
  return deployed == "anfis" ? member(fit, of_anfis) : member(member(member(fit, "baselines"), deployed), of_baseline);
}

// ---- the whole ----

constexpr std::string_view kHowToRead = R"html(<section id="reading"><h2>How to read this page</h2>
<p>A <b>row</b> is what one run says of a sensor at one plateau, estimated jointly from all six positions. The
<b>curve</b> is what the calibration file carries: the mean over all power-ons. Its dark <b>band</b> holds that mean with
95 % probability, the light one what the sensor will do after one fresh power-on. The offset that changes from power-on to
power-on (<b>run-to-run</b>) is what no thermal model can remove. <b>Held-out</b> errors come from runs that were not
fitted: <b>absolute</b> with the run's own offset, <b>shape</b> without it. A dash means that the data cannot say.
Numbers show three digits; the page's source has all of them (<code>&lt;data value&gt;</code>).</p></section>
)html";

std::string navigation(const json& sections) {
  const json& sensors = sections["sensors"];
  std::string html = "<nav aria-label=\"Sections\"><ul>\n";
  for (const std::string_view name : calib::kSensorNames) {
    if (sensors.contains(name)) html += fmt::format("<li><a href=\"#{0}\">{0}</a></li>\n", name);
  }
  if (!html::member(sections, "terms").empty()) html += "<li><a href=\"#terms\">accepted effects</a></li>\n";
  for (const char* id : {"couplings", "impact", "noise", "check", "records", "provenance", "reading"}) {
    html += fmt::format("<li><a href=\"#{0}\">{0}</a></li>\n", id);
  }
  return html + "</ul></nav>\n";
}

std::string title_of(const json& document) {
  return fmt::format("{}Calibration report, unit {}, model {}",
                     document["sections"]["summary"]["simulated"].get<bool>() ? "SIMULATED: " : "",
                     document["unit"].get<std::string>(), document["model"].get<int>());
}

std::string body(const json& document) {
  const json& sections = document["sections"];
  const json& sensors = sections["sensors"];
  std::string html = certificate_part(document, "certificate", "h1") + navigation(sections);
  html += more_warnings_part(sections["summary"]) + overview_part(sensors);
  for (const std::string_view name : calib::kSensorNames) {
    const json& sensor = html::member(sensors, name);
    if (!sensor.is_null()) html += sensor_part(name, sensor);
  }
  html += terms_part(html::member(sections, "terms"));
  html += couplings_part(sections["couplings"]);
  html += impact_part(html::member(sections, "impact"));
  html += noise_part(sections["noise"]);
  html += check_part(sections["check_standards"]) + records_part(sections["records"]);
  return html + provenance_part(document) + std::string(kHowToRead);
}

/// A text as a string of CSS: what is neither letter nor digit by its number, so that nothing ends the string or the
/// element that it is in.
std::string css_string(std::string_view text) {
  std::string css = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte >= 0x80 || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    css += plain ? std::string(1, c) : fmt::format("\\{:x} ", byte == 0 ? 0xfffd : static_cast<unsigned>(byte));
  }
  return css + "\"";
}

/// The foot of every printed page: what it is of, and its number.
std::string running_foot(const std::string& text) {
  return fmt::format(
      "@page{{@bottom-left{{font:8pt sans-serif;content:{}}}@bottom-right{{font:8pt sans-serif;content:\"page \" "
      "counter(page) \" of \" counter(pages)}}}}",
      css_string(text));
}

}  // namespace

std::string page_frame(const Frame& frame, std::string_view body, const json& data) {
  const Script script = figure_script(data);
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
      "img-src data:; script-src {}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" "
      "href=\"data:,\">\n<title>{}</title>\n<style>{}{}{}</style>\n</head>\n<body>\n{}<main>\n{}{}"
      "<footer>{}, {}</footer>\n</main>\n{}</body>\n</html>\n",
      script.policy, html::escaped(frame.title), find_web_file("colours.css")->content,
      find_web_file("report.css")->content, running_foot(frame.running), frame.simulated ? kSimulatedBar : "",
      kWithoutScript, body, html::escaped(frame.software), html::date_time(frame.created_utc_s), script.html);
}

std::string overview_part(const json& sensors) {
  html::Table table("All sensors", {"sensor", "unit", "in the file", "range, °C", "cross-validation, absolute",
                                    "cross-validation, shape", "run-to-run", "widest ci95", "widest pi95"});
  for (const std::string_view name : calib::kSensorNames) {
    const json& sensor = member(sensors, name);
    if (sensor.is_null()) continue;
    const json& fit = sensor["fit"];
    table.row({html::row_heading(name), html::html_cell(html::unit_text(sensor["unit"].get<std::string>())),
               html::text_cell(fit["deployed"].get<std::string>()),
               html::html_cell(html::number(fit["temp_min_c"].get<double>(), 1) + " to " +
                                   html::number(fit["temp_max_c"].get<double>(), 1),
                               true),
               html::number_cell(deployed_error(fit, "check_rmse", "rmse_abs")),
               html::number_cell(deployed_error(fit, "check_rmse_shape", "rmse_shape")),
               html::number_cell(member(fit, "run_to_run_sigma")), html::number_cell(largest(fit["curve"], "ci95")),
               html::number_cell(largest(fit["curve"], "pi95"))});
  }
  return "<section id=\"overview\"><h2>All curves</h2>\n" + table.html() + "</section>\n";
}

std::string report_page(const json& document) {
  const Frame frame = {title_of(document), document["software"].get<std::string>(),
                       document["created_utc_s"].get<double>(),
                       document["sections"]["summary"]["simulated"].get<bool>(),
                       "Calibration certificate " + certificate_number(document)};
  return page_frame(frame, body(document), figure_data(document["sections"]));
}

}  // namespace soak::station
