// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "calib/judge/control_chart.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"
#include "station/report/svg.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;
using svg::Mark;
using svg::Point;

constexpr double kWidth = 520.0;
constexpr double kHeight = 240.0;
constexpr svg::Box kBox = {66.0, 26.0, kWidth - 12.0, kHeight - 42.0};
constexpr std::array<std::string_view, 6> kSensorNames = {"gyro_x",  "gyro_y",  "gyro_z",
                                                          "accel_x", "accel_y", "accel_z"};

std::string unit_of(std::string_view sensor) { return sensor.starts_with("gyro") ? "deg/s" : "m/s²"; }

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

bool is_of(const json& names, const json& campaign) {
  return std::ranges::find(names, campaign["campaign"]) != names.end();
}

/// What one chart is drawn from.
struct Chart {
  std::vector<Point> points;
  std::vector<Point> of_model;
  std::vector<Point> out;
  std::vector<Point> centre;
  std::vector<Point> lower;
  std::vector<Point> upper;
};

Chart chart_of(const json& unit, const json& names, std::string_view sensor) {
  Chart chart;
  double number = 0.0;
  for (const json& campaign : unit["campaigns"]) {
    number += 1.0;
    const json& found = member(campaign["sensors"], sensor);
    if (found.is_null()) continue;
    const Point point{number, found["bias"]};
    const bool is_out = found["verdict"] == "out_of_control";
    (is_out ? chart.out : chart.points).push_back(point);
    if (is_of(names, campaign)) chart.of_model.push_back(point);
    const json& limits = found["limits"];
    if (limits.is_null()) continue;
    chart.centre.push_back({number, limits["centre"]});
    chart.lower.push_back({number, limits["lower"]});
    chart.upper.push_back({number, limits["upper"]});
  }
  return chart;
}

svg::Scale value_scale(const Chart& chart) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const auto* points : {&chart.points, &chart.out, &chart.lower, &chart.upper}) {
    for (const Point& point : *points) {
      low = std::min(low, point.y);
      high = std::max(high, point.y);
    }
  }
  const double room = high > low ? 0.06 * (high - low) : std::max(0.1 * std::abs(low), 1e-6);
  return {low - room, high + room};
}

std::string drawing(const json& unit, const json& names, std::string_view sensor, std::size_t ordinal) {
  const Chart chart = chart_of(unit, names, sensor);
  if (chart.points.empty() && chart.out.empty()) return {};
  const auto campaigns = static_cast<double>(unit["campaigns"].size());
  svg::Panel panel(kBox, {0.0, std::max(10.0, campaigns + 1.0)}, value_scale(chart));
  panel.axes("campaigns in the order of time",
             fmt::format("bias at {} °C, {}", unit["reference_c"].get<double>(), unit_of(sensor)));
  panel.line(chart.centre, "curve");
  panel.line(chart.lower, "limit");
  panel.line(chart.upper, "limit");
  panel.marks(chart.points, Mark::dot, "c0");
  panel.marks(chart.out, Mark::up, "out");
  panel.marks(chart.of_model, Mark::ring, "fresh");
  svg::Drawing drawing{fmt::format("check-{}-{}", ordinal, sensor),
                       fmt::format("{} of {}", sensor, html::text_of(unit, "unit"))};
  drawing.description = fmt::format("{} campaigns, {} of them out of control; those of this model are ringed.",
                                    chart.points.size() + chart.out.size(), chart.out.size());
  drawing.width = kWidth;
  drawing.height = kHeight;
  drawing.content = panel.svg();
  drawing.legend = {{"run c0", "campaign"}, {"ring fresh", "of this model"}};
  if (!chart.out.empty()) drawing.legend.push_back({"none", "▲ out of control"});
  if (!chart.centre.empty()) {
    drawing.legend.push_back({"line curve", "mean of earlier ones"});
    drawing.legend.push_back({"line limit", "limits"});
  }
  return svg::figure(drawing);
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
  for (const std::string_view sensor : kSensorNames) {
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

std::string table_of(const json& unit, const json& names) {
  html::Table table("The campaigns of this model on the charts",
                    {"campaign", "sensor", "unit", "bias", "limits", "from campaigns", "mean of the last eight",
                     "its limits", "verdict"});
  for (const json& campaign : unit["campaigns"]) {
    if (is_of(names, campaign)) add_rows(table, campaign);
  }
  return table.html();
}

std::string sentence_of(const json& unit, const json& names) {
  std::string html;
  for (const json& campaign : unit["campaigns"]) {
    if (!is_of(names, campaign)) continue;
    html += fmt::format("<p>Campaign {}: <b>{}</b>{}</p>\n", html::text_of(campaign, "campaign"),
                        verdict_words(campaign["verdict"]), campaign["simulated"].get<bool>() ? ", SIMULATED" : "");
  }
  return html;
}

std::string basis() {
  return fmt::format(
      "<p class=\"soft\">The unit above is measured in every campaign and deployed nowhere: what changes in it is a "
      "change of the station. Its biases are carried to one temperature. Limits: prediction limits of Student's t from "
      "mean and standard deviation of earlier campaigns in control, {} at least, the first {}; by chance at most {:g} "
      "% "
      "of campaigns in which nothing has changed are out of control. Fewer earlier campaigns: not established, nothing "
      "is judged.</p>\n",
      calib::kFewestForLimits, calib::kMostForLimits, 100.0 * calib::kFalseAlarmPerCampaign);
}

}  // namespace

std::string check_part(const json& check_standards) {
  std::string html = "<section id=\"check\"><h2>Check standards</h2>\n";
  const json& units = check_standards["units"];
  if (units.empty()) {
    return html +
           "<p>None was in the campaigns of this model: whether the station was as it had been before, nobody "
           "knows.</p></section>\n";
  }
  std::size_t ordinal = 0;
  for (json unit : units) {
    unit["reference_c"] = check_standards["reference_c"];
    const json& names = check_standards["campaigns"];
    html += fmt::format("<h3>Check standard {}{}</h3>\n", html::text_of(unit, "unit"),
                        unit["ended"].get<bool>() ? " (ended)" : "");
    html += sentence_of(unit, names) + table_of(unit, names) + "<div class=\"figures\">\n";
    for (const std::string_view sensor : kSensorNames) html += drawing(unit, names, sensor, ordinal);
    html += "</div>\n";
    ++ordinal;
  }
  return html + basis() + "</section>\n";
}

}  // namespace soak::station
