// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/nav/nav_json.h"
#include "station/report/html.h"
#include "station/report/page.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using nav::OutageResult;
using nlohmann::json;

/// Outages that are drawn one by one.
constexpr std::size_t kMostDrawn = 24;
/// Of one line: more than a figure has room for.
constexpr std::size_t kMostPoints = 300;

double horizontal_m(const nav::ErrorPoint& point) { return std::hypot(point.position_m.x(), point.position_m.y()); }

/// Of so many points those that are drawn, evenly spread, the first and the last among them.
std::vector<std::size_t> drawn_of(std::size_t points) {
  std::vector<std::size_t> drawn(std::min(points, kMostPoints));
  for (std::size_t i = 0; i < drawn.size(); ++i)
    drawn[i] = i * (points - 1) / std::max<std::size_t>(drawn.size() - 1, 1);
  return drawn;
}

json thinned(const json& line) {
  json thin = json::array();
  for (const std::size_t i : drawn_of(line.size())) thin.push_back(line[i]);
  return thin;
}

/// [seconds after the beginning, m] of the mean over the outages: at the truth nearest to each second, from that on by
/// which all have one, then at the end.
json mean_errors(std::span<const OutageResult> results, std::size_t pipeline, double length_s) {
  json line = json::array();
  double first_s = 0.0;
  double final_m = 0.0;
  for (const OutageResult& result : results) {
    first_s = std::max(first_s, std::ceil(result.pipelines[pipeline].points.front().after_s));
    final_m += result.pipelines[pipeline].horizontal_final_m / static_cast<double>(results.size());
  }
  for (double after_s = first_s; after_s < length_s; after_s += 1.0) {
    double sum_m = 0.0;
    for (const OutageResult& result : results) {
      const auto distance_s = [&](const nav::ErrorPoint& point) { return std::abs(point.after_s - after_s); };
      sum_m += horizontal_m(*std::ranges::min_element(result.pipelines[pipeline].points, {}, distance_s));
    }
    line.push_back({after_s, sum_m / static_cast<double>(results.size())});
  }
  line.push_back({length_s, final_m});
  return thinned(line);
}

/// What the two figures of an outage are drawn from: [east, north] of truth and pipelines, [seconds, m] of their
/// errors.
json outage_data(const OutageResult& result) {
  json data = {{"truth", json::array()}, {"tracks", json::array()}, {"errors", json::array()}};
  const std::vector<std::size_t> drawn = drawn_of(result.track_m.size());
  for (const std::size_t i : drawn) data["truth"].push_back({result.track_m[i].x(), result.track_m[i].y()});
  for (const nav::OutageErrors& pipeline : result.pipelines) {
    json track = json::array();
    json errors = json::array();
    for (const std::size_t i : drawn) {
      const nav::ErrorPoint& point = pipeline.points[i];
      const Eigen::Vector3d place_m = result.track_m[i] + point.position_m;
      track.push_back({place_m.x(), place_m.y()});
      errors.push_back({point.after_s, horizontal_m(point)});
    }
    data["tracks"].push_back(std::move(track));
    data["errors"].push_back(std::move(errors));
  }
  return data;
}

json drawn_data(const json& comparison, std::span<const OutageResult> results) {
  json data = {{"pipelines", json::array()}, {"mean", json::array()}, {"outages", json::array()}};
  for (std::size_t p = 0; p < comparison["pipelines"].size(); ++p) {
    data["pipelines"].push_back(comparison["pipelines"][p]["name"]);
    data["mean"].push_back(mean_errors(results, p, comparison["length_s"].get<double>()));
  }
  for (const OutageResult& result : results.first(std::min(results.size(), kMostDrawn))) {
    data["outages"].push_back(outage_data(result));
  }
  return data;
}

html::Cell estimate_cell(const json& estimate, double factor) {
  std::string cell = html::number(factor * estimate["value"].get<double>());
  const json& interval = estimate["ci95"];
  if (!interval.is_null()) {
    cell += fmt::format(" [{}, {}]", html::number(factor * interval[0].get<double>()),
                        html::number(factor * interval[1].get<double>()));
  }
  return html::html_cell(cell, true);
}

std::string pipelines_table(const json& pipelines) {
  html::Table table("Horizontal errors, means over outages, with 95 % intervals",
                    {"pipeline", "RMSE, m", "at the end, m", "less than the first, %", "is"});
  for (const json& pipeline : pipelines) {
    table.row({html::row_heading(pipeline["name"].get<std::string>()),
               estimate_cell(pipeline["horizontal_rmse_m"], 1.0), estimate_cell(pipeline["horizontal_final_m"], 1.0),
               estimate_cell(pipeline["gain"], 100.0), html::text_cell(pipeline["description"].get<std::string>())});
  }
  return table.html();
}

/// What must be known of the figures beside them.
std::string remarks_part(const json& comparison) {
  std::string paragraphs;
  for (const std::string& sentence : outage_remarks(comparison)) {
    paragraphs += fmt::format("<p>{}</p>\n", html::escaped(sentence));
  }
  return paragraphs;
}

std::string outage_figures(const OutageResult& result, std::size_t number) {
  const std::string title =
      fmt::format("Outage {}: {}, from {:.1f} s on", number + 1, result.drive, result.outage.begin_s);
  const std::string of = std::to_string(number);
  return figure("track", of, {title, "Track of the antenna: truth and what each pipeline takes for it."}) +
         figure("error", of, {title, "Horizontal position error of each pipeline over time."});
}

}  // namespace

std::string outages_page(const json& comparison, std::span<const OutageResult> results, const std::string& about,
                         const std::string& software, double created_utc_s) {
  const auto is_simulated = [](const json& drive) { return drive["truth"]["from"] == "simulation"; };
  const bool simulated = std::ranges::all_of(comparison["drives"], is_simulated);
  std::string body = fmt::format(
      "<h1>Navigation through outages</h1>\n<p>{} outages of {} s without satellite navigation, on {} drive{}; every "
      "pipeline meets the same ones. {}</p>\n<section id=\"pipelines\"><h2>Pipelines</h2>\n{}{}<div "
      "class=\"figures "
      "single\">\n",
      results.size(), comparison["length_s"].get<double>(), comparison["drives"].size(),
      comparison["drives"].size() == 1 ? "" : "s", html::escaped(about), pipelines_table(comparison["pipelines"]),
      remarks_part(comparison));
  body += figure("error", "mean",
                 {"All outages", "Horizontal position error of each pipeline over time, mean over all outages."});
  const std::size_t drawn = std::min(results.size(), kMostDrawn);
  body += fmt::format(
      "</div></section>\n<section id=\"outages\"><h2>Single outages</h2>\n<p>{} of {} are drawn.</p>\n"
      "<div class=\"figures\">\n",
      drawn, results.size());
  for (std::size_t i = 0; i < drawn; ++i) body += outage_figures(results[i], i);
  body += "</div></section>\n";
  const std::string title = fmt::format("{}Navigation through outages", simulated ? "SIMULATED: " : "");
  return page_frame({title, software, created_utc_s, simulated}, body, drawn_data(comparison, results));
}

}  // namespace soak::station
