// SPDX-License-Identifier: Apache-2.0
#include "station/report/page.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::string_view kHowToRead = R"html(<section id="reading"><h2>How to read this page</h2>
<p>A <b>row</b> is what one run says of a sensor at one plateau, estimated jointly from all six positions. The
<b>curve</b> is what the calibration file carries: the mean over all power-ons. Its dark <b>band</b> holds that mean with
95 % probability, the light one what the sensor will do after one fresh power-on. The offset that changes from power-on to
power-on (<b>run-to-run</b>) is what no thermal model can remove. <b>Held-out</b> errors come from runs that were left out
of the fit: <b>absolute</b> with the run's own offset, <b>shape</b> without it. A dash means that the data cannot say.
Numbers show three digits; the page's source has all of them (<code>&lt;data value&gt;</code>).</p></section>
)html";

/// The sensors in their usual order, whatever the order of the document.
constexpr std::string_view kOrder[] = {"gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"};

std::string navigation(const json& sections) {
  const json& sensors = sections["sensors"];
  std::string html = "<nav aria-label=\"Sections\"><ul>\n";
  for (const std::string_view name : kOrder) {
    if (sensors.contains(name)) html += fmt::format("<li><a href=\"#{0}\">{0}</a></li>\n", name);
  }
  if (!html::member(sections, "terms").empty()) html += "<li><a href=\"#terms\">accepted effects</a></li>\n";
  for (const char* id : {"couplings", "noise", "check", "records", "provenance", "reading"}) {
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
  std::string html = head_part(document) + warnings_part(sections["summary"]) + overview_part(sensors);
  html += navigation(sections);
  for (const std::string_view name : kOrder) {
    const json& sensor = html::member(sensors, name);
    if (!sensor.is_null()) html += sensor_part(name, sensor);
  }
  html += terms_part(html::member(sections, "terms"));
  html += couplings_part(sections["couplings"]) + noise_part(sections["noise"]);
  html += check_part(sections["check_standards"]) + records_part(sections["records"]);
  return html + provenance_part(document) + std::string(kHowToRead);
}

}  // namespace

std::string report_page(const json& document) {
  return page_frame(title_of(document), body(document), document["software"].get<std::string>(),
                    document["created_utc_s"], document["sections"]["summary"]["simulated"].get<bool>());
}

}  // namespace soak::station
