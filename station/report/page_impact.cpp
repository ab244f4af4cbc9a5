// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::string_view kHeading = "<section id=\"impact\"><h2>What the calibration buys in navigation</h2>\n";

std::string drift_table(const json& sensors) {
  html::Table table("Position error from each sensor's bias alone, m",
                    {"sensor", "unit", "change of the bias", "left of it, 95 %", "by", "after 30 s, without",
                     "after 30 s, with", "after 60 s, without", "after 60 s, with"});
  for (const json& sensor : sensors) {
    std::vector<html::Cell> cells = {html::row_heading(sensor["sensor"].get<std::string>()),
                                     html::html_cell(html::unit_text(sensor["unit"].get<std::string>())),
                                     html::number_cell(sensor["change"]), html::number_cell(sensor["left"]),
                                     html::html_cell(html::text_of(sensor, "left_interval"))};
    for (const char* time : {"after_30_s_m", "after_60_s_m"}) {
      for (const char* which : {"without", "with"}) cells.push_back(html::number_cell(sensor[time][which]));
    }
    table.row(cells);
  }
  return table.html();
}

std::string with_interval(const json& estimate, double factor, int digits) {
  std::string text = html::number(factor * estimate["value"].get<double>(), digits);
  if (const json& interval = estimate["ci95"]; interval.is_array()) {
    text += fmt::format(" [{}, {}]", html::number(factor * interval[0].get<double>(), digits),
                        html::number(factor * interval[1].get<double>(), digits));
  }
  return text;
}

std::string drives_table(const json& drives) {
  html::Table table("Position error of a navigation filter in outages on simulated drives, m [95 %]",
                    {"this calibration", "at the end of an outage", "root mean square"});
  for (const char* which : {"without", "with"}) {
    const json& errors = drives[which];
    table.row({html::row_heading(which), html::html_cell(with_interval(errors["horizontal_final_m"], 1.0, 1)),
               html::html_cell(with_interval(errors["horizontal_rmse_m"], 1.0, 1))});
  }
  return table.html();
}

/// Where they could not be simulated a warning says why.
std::string drives_part(const json& impact) {
  const json& drives = impact["drives"];
  if (drives.is_null()) {
    const bool told = std::ranges::any_of(
        impact["warnings"], [](const json& warning) { return warning["code"] == "drives_not_simulated"; });
    if (told) return "";
    return "<p>Drives with a navigation filter: not simulated, as the calibration does not state its "
           "uncertainty.</p>\n";
  }
  return fmt::format(
             "<p>With a navigation filter and satellite navigation until the outage: {} outages of {} s on {} "
             "simulated "
             "drives with this unit's curves, the temperature going the same way. Errors that no calibration of the "
             "temperature removes, such as noise, are assumed: those of an AHRS400CA for every unit, not those of this "
             "unit's type.</p>\n",
             drives["outages"].get<int>(), html::number(drives["length_s"].get<double>(), 0),
             drives["drives"].get<int>()) +
         drives_table(drives) +
         fmt::format("<p>Gain at the end of an outage: {} %.</p>\n", with_interval(drives["gain"], 100.0, 0));
}

}  // namespace

std::string impact_part(const json& impact) {
  std::string html(kHeading);
  if (!impact.is_object()) {
    return html + "<p>Not known: the sensors were not calibrated at two common temperatures.</p></section>\n";
  }
  html += fmt::format(
      "<p>Without satellite navigation, while the temperature goes from {} °C at power-on to {} °C; the bias at "
      "power-on is known, the sensor's axis lies horizontally. <b>With</b>: from what the calibration leaves (95 %), "
      "<i>by</i> <code>pi95</code> for one fresh power-on; <code>ci95</code> is of the mean curve alone, and can be "
      "much too small.</p>\n",
      html::number(impact["from_c"].get<double>(), 1), html::number(impact["to_c"].get<double>(), 1));
  html += drift_table(impact["free_inertial"]);
  for (const json& warning : impact["warnings"]) html += "<p>" + html::text_of(warning, "text") + ".</p>\n";
  return html + drives_part(impact) + "</section>\n";
}

}  // namespace soak::station
