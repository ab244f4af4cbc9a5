// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "station/report/html.h"
#include "station/report/page_parts.h"
#include "station/report/term_text.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

constexpr double kExpectedInside = 0.95;  ///< share of errors inside a 95 % band

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
  if (fit["deployed"] == "constant") return "<p>All runs are of one temperature: the model is a constant.</p>\n";
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
  const std::string fold = html::text_of(sensor["fit"], "holdout");
  html::Table table(fmt::format("Each fold: absolute error on the runs not fitted, {}", unit_of(sensor)),
                    {fold, "anfis", "poly3", "poly5", "spline"});
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
    cells.push_back({.html = html::said(part.value("basis", "–")), .style = "basis"});
    table.row(cells);
  }
  return table.html();
}

bool has_pi95(const json& fit) {
  return std::ranges::any_of(fit["curve"], [](const json& point) { return member(point, "pi95").is_number(); });
}

/// The uncertainty budget, where the stored model states it.
std::string budget_table(const json& sensor) {
  const json& budget = member(sensor["fit"], "uncertainty");
  if (!budget.is_array() || budget.empty()) {
    return "<h3>Uncertainty budget</h3><p>Not stated: the model was stored by a version of Soak without a budget. Fit "
           "again to get one.</p>\n";
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
       rules > 0 ? fmt::format("{} rules, {}", rules, html::text_of(fit, "membership")) : "none: too few temperatures"},
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
        "<p>Scale error: curve by {}, in ppm; to correct a reading subtract the bias, then divide by 1 + "
        "scale/10⁶.</p>\n",
        html::escaped(deployed.get<std::string>()));
  }
  if (name.starts_with("gyro")) {
    return "<p>Scale error: not known. A gyro at rest senses no rate that could show its scale; it takes positions in "
           "which the fixture turns at known rates, or movements by hand between rests. The file says so, and leaves "
           "the scale at its nominal value.</p>\n";
  }
  return "<p>Scale error: not known. The axis was never turned against gravity; it takes positions with the axis up "
         "and down.</p>\n";
}

/// How many of the errors are inside the band of a fresh power-on, and what that means where they are few.
std::string band_words(const json& share) {
  if (!share.is_number()) return {};
  const double inside = share.get<double>();
  std::string text =
      fmt::format(" {} % of the errors are inside the band of a fresh power-on", html::number(100.0 * inside, 0));
  if (inside >= kExpectedInside) return text + ".";
  return text +
         ", of which 95 % are expected over many power-ons. The errors of one power-on share its offset, so that those "
         "of one or two runs may lie beside the band together. The verdict rests on the errors and the limit, not on "
         "this band.";
}

/// What fresh runs say of one curve.
std::string tested_words(std::string_view what, const json& result, const std::string& unit) {
  if (result["worst_abs"].is_null()) return fmt::format("{}: not measured. ", what);
  const std::string inside = band_words(result["inside_pi95"]);
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
  if (result.is_null()) return "<p>Fresh runs: none measured this sensor.</p>\n";
  return "<p>Fresh runs, which no fit has seen. " + tested_words("Bias", result["bias"], unit_of(sensor)) +
         (result["scale"].is_null() ? "" : tested_words("Scale", result["scale"], "ppm")) + "</p>\n";
}

// ---- figures ----

/// The points of the deployed curve that have this value.
std::vector<std::pair<double, double>> curve_points(const json& sensor, const char* key) {
  std::vector<std::pair<double, double>> points;
  for (const json& point : sensor["fit"]["curve"]) {
    if (member(point, key).is_number()) points.emplace_back(point["temp_c"], point[key]);
  }
  return points;
}

std::string curve_figure(std::string_view name, const json& sensor) {
  const auto curve = curve_points(sensor, "bias");
  double widest = 0.0;
  for (const auto& [temp_c, half_width] : curve_points(sensor, "ci95")) widest = std::max(widest, half_width);
  return figure("curve", name,
                {fmt::format("{}: bias over temperature", name),
                 fmt::format("Deployed curve from {:.3g} {} at {:.1f} °C to {:.3g} at {:.1f} °C, largest half-width of "
                             "its 95 % band {:.3g}.",
                             curve.front().second, unit_of(sensor), curve.front().first, curve.back().second,
                             curve.back().first, widest)});
}

/// Empty where there are no rows.
std::string residual_figure(std::string_view name, const json& sensor) {
  const json& rows = sensor["rows"];
  if (rows.is_null() && sensor["fresh"].is_null()) return {};
  Caption caption{fmt::format("{}: residuals, rows minus curve", name), {}};
  if (!rows.is_null()) {
    caption.description = fmt::format(
        "Residuals of {} rows, RMS {:.3g} {}, largest {:.3g} in run {}; with each run's offset removed RMS {:.3g}.",
        rows["total"].get<std::size_t>(), rows["rmse_abs"].get<double>(), unit_of(sensor),
        rows["worst_abs"].get<double>(), rows["worst_run"].get<std::string>(), rows["rmse_shape"].get<double>());
  }
  return figure("residuals", name, caption);
}

/// Empty where there is no such curve.
std::string scale_figure(std::string_view name, const json& sensor) {
  const auto curve = curve_points(sensor, "scale_ppm");
  if (curve.empty()) return {};
  return figure("scale", name,
                {fmt::format("{}: scale error over temperature", name),
                 fmt::format("Deployed curve from {:.4g} ppm at {:.1f} °C to {:.4g} ppm at {:.1f} °C.",
                             curve.front().second, curve.front().first, curve.back().second, curve.back().first)});
}

}  // namespace

std::string sensor_part(std::string_view name, const json& sensor) {
  std::string html = fmt::format("<section id=\"{0}\" class=\"sensor\"><h2>{0}</h2>\n", html::escaped(name));
  html += model_facts(sensor);
  if (sensor["fit"].value("relative", false)) {
    html += "<p>One attitude only: this bias has no absolute level; it is relative to the bias at 25 °C.</p>\n";
  }
  if (sensor["rows"].is_null()) html += "<p>The rows of the fit cannot be shown: see the warnings.</p>\n";
  // Beside the third drawing there is room for the tables.
  const std::string scale = scale_figure(name, sensor);
  const std::string tables = "<div class=\"tables\">\n" + errors_table(sensor) + folds_table(sensor) + "</div>\n";
  html += "<div class=\"figures\">\n" + curve_figure(name, sensor) + residual_figure(name, sensor) + scale +
          (scale.empty() ? "" : tables) + "</div>\n";
  html += scale_words(name, sensor) + verification_words(sensor) + (scale.empty() ? tables : "");
  return html + budget_table(sensor) + "</section>\n";
}

}  // namespace soak::station
