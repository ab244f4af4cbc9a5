// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "station/report/charts.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

constexpr std::array<std::string_view, 4> kFamilies = {"anfis", "poly3", "poly5", "spline"};

std::string unit_of(const json& sensor) { return html::unit_text(sensor["unit"].get<std::string>()); }

/// Held-out errors of one family: {absolute, shape}.
std::pair<json, json> errors_of(const json& fit, std::string_view family) {
  if (family == "anfis") return {member(fit, "check_rmse"), member(fit, "check_rmse_shape")};
  const json& baseline = member(member(fit, "baselines"), family);
  return {member(baseline, "rmse_abs"), member(baseline, "rmse_shape")};
}

std::string errors_table(const json& sensor) {
  const json& fit = sensor["fit"];
  html::Table table("Held-out errors, " + unit_of(sensor), {"family", "absolute", "shape", ""});
  for (const std::string_view family : kFamilies) {
    const auto [absolute, shape] = errors_of(fit, family);
    const bool deployed = fit["deployed"] == family;
    table.row({html::row_heading(family),
               html::number_cell(absolute),
               html::number_cell(shape),
               {.html = deployed ? "✓ in the file" : "", .style = deployed ? "winner" : ""}});
  }
  return table.html();
}

std::string folds_table(const json& sensor) {
  const json& checks = member(sensor["fit"], "checks");
  if (!checks.is_array() || checks.empty()) return {};
  const std::string left_out = html::text_of(sensor["fit"], "holdout");
  html::Table table(fmt::format("Each fold: absolute error of what was left out, {}", unit_of(sensor)),
                    {left_out, "anfis", "poly3", "poly5", "spline"});
  for (const json& check : checks) {
    std::vector<html::Cell> cells = {html::row_heading(check["held_out"].get<std::string>())};
    for (const std::string_view family : kFamilies) cells.push_back(html::number_cell(member(check, family)));
    table.row(cells);
  }
  return table.html();
}

/// Largest standard uncertainty of a contribution to one band, and that at 25 °C; dashes where the curve has no such
/// band.
void add_spread(std::vector<html::Cell>& cells, const json& part, std::string_view band, bool has_band) {
  const bool is_missing = has_band && !part.value("stated", true);
  for (const char* key : {"max", "at_25c"}) {
    const json& value = member(member(part, band), key);
    cells.push_back(value.is_number() ? html::number_cell(value)
                                      : html::Cell{.html = is_missing ? "not stated" : "–", .style = "nowrap"});
  }
}

std::string budget_rows(const std::string& caption, const json& budget, bool has_pi95) {
  html::Table table(caption, {"contribution", "type", "degrees of freedom", "mean curve, largest", "at 25 °C",
                              "fresh power-on, largest", "at 25 °C", "basis"});
  for (const json& part : budget) {
    const json& freedom = member(part, "degrees_of_freedom");
    std::vector<html::Cell> cells = {html::row_heading(part.value("name", "")),
                                     html::html_cell(html::text_of(part, "type")),
                                     html::html_cell(freedom.is_number() ? html::number(freedom) : "∞")};
    add_spread(cells, part, "curve", true);
    add_spread(cells, part, "fresh_power_on", has_pi95);
    cells.push_back({.html = html::text_of(part, "basis"), .style = "basis"});
    table.row(cells);
  }
  return table.html();
}

bool has_pi95(const json& fit) {
  return std::ranges::any_of(fit["curve"], [](const json& point) { return member(point, "pi95").is_number(); });
}

/// The uncertainty budget; models from before there was one do not state it.
std::string budget_table(const json& sensor) {
  const json& budget = member(sensor["fit"], "uncertainty");
  if (!budget.is_array() || budget.empty()) {
    return "<h3>Uncertainty budget</h3><p>Not stated: the model was stored by a version of Soak that kept no budget. "
           "Fit again to have one.</p>\n";
  }
  std::string html = budget_rows("Uncertainty budget of the bias: standard uncertainties (k = 1), " + unit_of(sensor),
                                 budget, has_pi95(sensor["fit"]));
  const json& scale = member(sensor["fit"], "scale_uncertainty");
  if (scale.is_array()) html += budget_rows("Uncertainty budget of the scale, ppm", scale, false);
  return html;
}

std::string model_facts(const json& sensor) {
  const json& fit = sensor["fit"];
  const std::string unit = " " + unit_of(sensor);
  const int rules = fit.value("rules", 0);
  std::vector<std::pair<std::string, std::string>> list = {
      {"In the file", html::text_of(fit, "deployed")},
      {"ANFIS",
       rules > 0 ? fmt::format("{} rules, {}", rules, html::text_of(fit, "membership")) : "none: too few plateaus"},
      {"Valid range", fmt::format("{} to {} °C", html::number(fit["temp_min_c"].get<double>(), 1),
                                  html::number(fit["temp_max_c"].get<double>(), 1))},
      {"Run-to-run", member(fit, "run_to_run_sigma").is_number() ? html::number(fit["run_to_run_sigma"]) + unit
                                                                 : "not known: one run"},
      {"Scatter within runs", html::number(member(fit, "lack_of_fit_sigma")) + unit},
      {"Runs", std::to_string(member(fit, "runs").size())}};
  if (!sensor["rows"].is_null()) {
    list.emplace_back("Largest residual",
                      fmt::format("{}{} at {} °C in {}", html::number(sensor["rows"]["worst_abs"]), unit,
                                  html::number(sensor["rows"]["worst_temp_c"].get<double>(), 1),
                                  html::text_of(sensor["rows"], "worst_run")));
  }
  return html::facts(list);
}

std::string scale_words(std::string_view name, const json& sensor) {
  const json& deployed = member(sensor["fit"], "scale_deployed");
  if (deployed.is_string()) {
    return fmt::format(
        "<p>Scale error: curve by {}, in ppm; to correct a reading subtract the bias, then divide by "
        "1 + scale/10⁶.</p>\n",
        html::escaped(deployed.get<std::string>()));
  }
  if (name.starts_with("gyro")) {
    return "<p>Scale error: not known. A gyro at rest senses no rate that could show its scale; it takes positions in "
           "which the fixture turns at known rates. The file says so, and leaves the scale at its nominal value.</p>\n";
  }
  return "<p>Scale error: not known. The axis was never turned against gravity; it takes positions with the axis up "
         "and "
         "down.</p>\n";
}

/// What fresh runs say of one curve.
std::string tested_words(std::string_view what, const json& result, const std::string& unit) {
  if (result["worst_abs"].is_null()) return fmt::format("{}: not measured. ", what);
  const std::string inside = result["inside_pi95"].is_number()
                                 ? fmt::format(" {} % of the errors are inside the band of a fresh power-on.",
                                               html::number(100.0 * result["inside_pi95"].get<double>(), 0))
                                 : "";
  const std::string limit = result["limit"].is_number()
                                ? fmt::format("limit {} {}, guard band {}: <b>{}</b>", html::number(result["limit"]),
                                              unit, html::number(result["guard"]), html::text_of(result, "verdict"))
                                : "no limit, so not judged";
  return fmt::format("{}: worst error {} {} at {} °C over {} rows, RMS {} absolute and {} shape; {}.{} ", what,
                     html::number(result["worst_abs"]), unit, html::number(result["worst_temp_c"].get<double>(), 1),
                     html::text_of(result, "rows"), html::number(result["rmse_abs"]),
                     html::number(result["rmse_shape"]), limit, inside);
}

std::string verification_words(const json& sensor) {
  const json& result = sensor["verification"];
  if (result.is_null()) return "<p>Fresh runs: none has tested this sensor.</p>\n";
  return "<p>Fresh runs, which no fit has seen. " + tested_words("Bias", result["bias"], unit_of(sensor)) +
         (result["scale"].is_null() ? "" : tested_words("Scale", result["scale"], "ppm")) + "</p>\n";
}

}  // namespace

std::string sensor_part(std::string_view name, const json& sensor) {
  std::string html = fmt::format("<section id=\"{0}\" class=\"sensor\"><h2>{0}</h2>\n", html::escaped(name));
  html += model_facts(sensor);
  if (sensor["fit"].value("relative", false)) {
    html += "<p>One attitude only: this bias has no level of its own, it is relative to that at 25 °C.</p>\n";
  }
  if (sensor["rows"].is_null()) html += "<p>The rows of the fit cannot be shown: see the warnings.</p>\n";
  // Beside the third drawing there is room for the tables.
  const std::string scale = scale_chart(name, sensor);
  const std::string tables = "<div class=\"tables\">\n" + errors_table(sensor) + folds_table(sensor) + "</div>\n";
  html += "<div class=\"figures\">\n" + curve_chart(name, sensor) + residual_chart(name, sensor) + scale +
          (scale.empty() ? "" : tables) + "</div>\n";
  html += scale_words(name, sensor) + verification_words(sensor) + (scale.empty() ? tables : "");
  return html + budget_table(sensor) + "</section>\n";
}

}  // namespace soak::station
