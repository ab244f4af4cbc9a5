// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "station/report/html.h"
#include "station/report/page_parts.h"
#include "station/report/term_text.h"

namespace soak::station {
namespace {

using nlohmann::json;

std::string list_of(const json& names) {
  return html::escaped(fmt::format("{}", fmt::join(names.get<std::vector<std::string>>(), ", ")));
}

std::string parameters_of(const json& part) {
  std::string text;
  const json& covariance = part["covariance"];
  std::size_t estimated = 0;
  while (estimated * estimated < covariance.size()) ++estimated;
  for (std::size_t i = 0; i < part["parameters"].size(); ++i) {
    const json& parameter = part["parameters"][i];
    const calib::TermParameter given{parameter["name"], parameter["value"], parameter["unit"]};
    const calib::TermParameter printed = printed_parameter(given);
    text +=
        fmt::format("{}{} = {}", text.empty() ? "" : "<br>", html::escaped(printed.name), html::number(printed.value));
    if (i < estimated) {
      const double half_width = 1.96 * std::sqrt(covariance[i * estimated + i].get<double>());
      text += " ± " + html::number(printed_parameter({given.name, half_width, given.unit}).value);
    }
    if (printed.unit != "1") text += " " + html::escaped(html::unit_text(printed.unit));
  }
  return text;
}

std::string parameter_table(const json& term) {
  html::Table table("Parameters (95 %)", {"Sensors", "Value"});
  for (const json& part : term["parts"]) {
    table.row({html::text_cell(fmt::format("{}", fmt::join(part["sensors"].get<std::vector<std::string>>(), ", "))),
               html::html_cell(parameters_of(part))});
  }
  return table.html();
}

std::string term_html(const json& term) {
  const json& rivals = term["confusable_with"];
  return fmt::format("<h3>{}</h3>\n{}{}", html::text_of(term, "name"),
                     html::facts({{"Found missing from", "model " + html::text_of(term, "parent_version")},
                                  {"Probability that scatter looks like this", html::number(term["p_adjusted"])},
                                  {"Explained nearly as much", rivals.empty() ? "nothing" : list_of(rivals)},
                                  {"Where it is corrected", term["lab_only"].get<bool>()
                                                                ? "lab only: the unit in its vehicle cannot correct it"
                                                                : "in the calibration file"}}),
                     parameter_table(term));
}

std::string gap_table(const json& gap) {
  html::Table table("Gap on runs used for neither the base nor the parameters, when the effects were accepted",
                    {"Sensor", "Unit", "Before", "After", "Floor", "Closed"});
  for (const auto& [sensor, entry] : gap.items()) {
    const bool gyro = sensor.starts_with("gyro");
    const double factor = gyro ? 180.0 / std::numbers::pi : 1.0;
    const auto figure = [&](const char* key) { return html::number_cell(entry[key].get<double>() * factor); };
    table.row({html::row_heading(sensor), html::text_cell(gyro ? "°/s" : "m/s²"), figure("before_rms"),
               figure("after_rms"), figure("floor_rms"),
               entry["closed_fraction"].is_null()
                   ? html::text_cell("too small to tell")
                   : html::html_cell(html::number(100.0 * entry["closed_fraction"].get<double>(), 0) + " %", true)});
  }
  return table.html();
}

}  // namespace

std::string terms_part(const json& terms) {
  if (terms.empty()) return {};
  std::string html =
      "<section id=\"terms\"><h2>Accepted effects</h2>\n<p>Found missing from an earlier model and added to this one. "
      "They were subtracted from the readings before the curves were fitted; rows and residuals on this page do not "
      "contain them.</p>\n";
  for (const json& term : terms) html += term_html(term);
  return html + gap_table(terms.back()["gap"]) + "</section>\n";
}

}  // namespace soak::station
