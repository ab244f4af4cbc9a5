// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sodium.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "base/hash.h"
#include "base/text.h"
#include "station/http/web_files.h"
#include "station/report/drawn_points.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

/// What web/report.mjs needs, each after what it imports.
constexpr std::array<std::string_view, 7> kModules = {
    "format.mjs", "dom.mjs", "axes.mjs", "figure.mjs", "figure_words.mjs", "sensor_figures.mjs", "report.mjs"};

/// A module as part of one script: without its imports, which stand before it.
std::string joined_module(std::string_view name) {
  std::string text;
  std::string_view rest = find_web_file(name)->content;
  while (!rest.empty()) {
    std::string_view line = rest.substr(0, rest.find('\n') + 1);
    rest.remove_prefix(line.size());
    if (line.starts_with("import ")) continue;
    if (line.starts_with("export ")) line.remove_prefix(7);
    text += line;
  }
  return text;
}

/// Numbers with as many digits as a drawing can show.
json rounded(const json& node) {
  if (node.is_number_float()) return base::parse_double(fmt::format("{:.8g}", node.get<double>())).value_or(0.0);
  json copy = node;
  if (copy.is_structured()) {
    for (json& part : copy) part = rounded(part);
  }
  return copy;
}

/// A list of objects as one object of lists.
json columns(const json& points, const std::vector<const char*>& keys) {
  json lists = json::object();
  for (const char* key : keys) {
    for (const json& point : points) lists[key].push_back(member(point, key));
  }
  return lists;
}

json rows_data(const json& rows) {
  if (rows.is_null()) return rows;
  return {{"runs", rows["runs"]},
          {"total", rows["total"]},
          {"points", columns(rows["points"], {"run", "sweep", "temp_c", "value", "residual", "shape_residual"})}};
}

/// The points of a sensor; null where they cannot be had.
json points_data(const json& sensor) {
  return {{"limit", sensor["limit"]},
          {"rows", rows_data(sensor["rows"])},
          {"scale_rows", rows_data(sensor["scale_rows"])},
          {"fresh", rows_data(sensor["fresh"])}};
}

json sensor_data(const json& sensor) {
  const json& fit = sensor["fit"];
  json data = points_data(sensor);
  data["unit"] = sensor["unit"];
  data["temp_min_c"] = fit["temp_min_c"];
  data["temp_max_c"] = fit["temp_max_c"];
  data["curve"] = columns(fit["curve"], {"temp_c", "bias", "ci95", "pi95", "scale_ppm", "scale_ci95_ppm"});
  return data;
}

}  // namespace

std::string figure(std::string_view chart, std::string_view of, const Caption& caption, std::string_view attributes) {
  return fmt::format(
      "<figure data-chart=\"{}\" data-of=\"{}\"{}>\n<figcaption><b>{}</b> <span>{}</span></figcaption>\n</figure>\n",
      chart, html::escaped(of), attributes, html::escaped(caption.title), html::escaped(caption.description));
}

json drawn_points(const json& sensors) {
  json data = json::object();
  for (const auto& [name, sensor] : sensors.items()) data[name] = rounded(points_data(sensor));
  return data;
}

json figure_data(const json& sections) {
  json data = {{"sensors", json::object()}, {"noise", json::object()}, {"check", json::array()}};
  for (const auto& [name, sensor] : sections["sensors"].items()) data["sensors"][name] = sensor_data(sensor);
  for (const auto& [name, noise] : sections["noise"]["sensors"].items()) {
    data["noise"][name] = {
        {"tau_s", member(noise, "tau_s")}, {"oadev", member(noise, "oadev")}, {"ci95", member(noise, "ci95")}};
  }
  const json& standards = sections["check_standards"];
  for (const json& unit : standards["units"]) {
    json campaigns = json::array();
    for (const json& campaign : unit["campaigns"]) {
      const bool of_model = is_of_model(standards, campaign);
      campaigns.push_back({{"of_model", of_model}, {"sensors", campaign["sensors"]}});
    }
    data["check"].push_back({{"reference_c", standards["reference_c"]}, {"campaigns", std::move(campaigns)}});
  }
  return data;
}

Script figure_script(const json& data) {
  std::string program;
  for (const std::string_view name : kModules) program += joined_module(name);
  const base::Sha256Digest digest =
      base::sha256({reinterpret_cast<const std::uint8_t*>(program.data()), program.size()});
  std::array<char, 64> hash{};
  sodium_bin2base64(hash.data(), hash.size(), digest.data(), digest.size(), sodium_base64_VARIANT_ORIGINAL);
  std::string text = rounded(data).dump(-1, ' ', false, json::error_handler_t::replace);
  // Nothing that somebody wrote may end the element.
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");
  }
  return {
      fmt::format("<script type=\"application/json\" id=\"data\">{}</script>\n<script type=\"module\">{}</script>\n",
                  text, program),
      fmt::format("'sha256-{}'", hash.data())};
}

}  // namespace soak::station
