// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/vocabulary/reference.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using html::member;
using nlohmann::json;

constexpr double kMillirad = 1000.0;
constexpr double kMicro = 1e6;

/// An entry of a coupling that may be absent, times a factor: null where it is.
json entry_of(const json& coupling, const char* key, std::size_t i, std::size_t j, double factor) {
  const json& matrix = member(coupling, key);
  return matrix.is_array() && matrix[i][j].is_number() ? json(matrix[i][j].get<double>() * factor) : json();
}

/// "value ± standard error", and the half-width of 95 % where the model states it.
std::string coupling_text(const json& coupling, std::size_t i, std::size_t j, double factor) {
  const json value = entry_of(coupling, "value", i, j, factor);
  const json error = entry_of(coupling, "standard_error", i, j, factor);
  if (value == 0.0 && error == 0.0) return "–";
  const json ci95 = entry_of(coupling, "ci95", i, j, factor);
  return html::number(value) + " ± " + html::number(error) +
         (ci95.is_null() ? "" : "<br>95 %: ± " + html::number(ci95));
}

/// A 3 × 3 table.
std::string coupling_table(std::string_view caption, const json& coupling, std::string_view kind, double factor) {
  html::Table table(caption, {"sensor", "force along x", "along y", "along z"});
  for (std::size_t i = 0; i < 3; ++i) {
    std::vector<html::Cell> cells = {html::row_heading(fmt::format("{}_{}", kind, "xyz"[i]))};
    for (std::size_t j = 0; j < 3; ++j) cells.push_back(html::html_cell(coupling_text(coupling, i, j, factor), true));
    table.row(cells);
  }
  return table.html();
}

/// Whether the model says how far the fixture may be off, which no reading shows.
std::string type_b_words(const json& coupling) {
  if (entry_of(coupling, "type_b", 0, 1, 1.0).is_number()) {
    return " The 95 % intervals include what the fixture's squareness adds (type B).";
  }
  return " What the fixture's squareness adds (type B) is not stated: no reference was entered for it.";
}

std::string even_order_table(const json& terms) {
  if (!terms.is_array()) return {};
  html::Table table("Even-order term of the accelerometers, µg/g²", {"sensor", "value ± standard error", "95 %: ±"});
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const json& term = terms[i];
    const auto cell = [&](const char* key) {
      return term.is_object() ? html::number(term[key].get<double>() * kMicro) : std::string("–");
    };
    table.row({html::row_heading(fmt::format("accel_{}", "xyz"[i])),
               html::html_cell(cell("value") + " ± " + cell("standard_error"), true),
               html::html_cell(cell("ci95"), true)});
  }
  return table.html();
}

/// How far the chamber was out of level; nothing for models from before that was estimated.
std::string level_words(const json& level) {
  if (!level.is_object()) return {};
  if (!level.at("north_rad").is_object()) {
    return "<p>Level error of the chamber: not known; " + html::text_of(level, "reason") + ".</p>\n";
  }
  const auto lean = [&](const char* key) {
    const json& stated = level.at(key);
    return html::number(stated["value"].get<double>() * kMillirad) + " ± " +
           html::number(stated["ci95"].get<double>() * kMillirad) + " mrad";
  };
  return "<p>Level error of the chamber, subtracted (95 %): the true vertical leans " + lean("north_rad") +
         " to north and " + lean("east_rad") + " to east of the fixture's.</p>\n";
}

struct Term {
  const char* key;
  const char* name;
};
constexpr Term kTerms[] = {{"angle_random_walk", "random walk of the integral (N)"},
                           {"bias_instability", "bias instability (B)"},
                           {"rate_random_walk", "rate random walk (K)"},
                           {"rate_ramp", "rate ramp (R)"},
                           {"quantization", "quantisation (Q)"},
                           {"markov_sigma", "Markov process, σ"},
                           {"markov_time", "Markov process, time"}};

/// What was found, or what could have stayed hidden.
std::string coefficient_text(const json& coefficient) {
  if (coefficient.is_null()) return "–";
  const json& interval = coefficient["ci95"];
  const std::string unit = html::unit_text(coefficient["unit"].get<std::string>());
  if (coefficient.value("found", false)) {
    return fmt::format("{} {} ({} to {})", html::number(coefficient["value"]), unit, html::number(interval[0]),
                       html::number(interval[1]));
  }
  return interval[1].is_number() ? fmt::format("none seen; below {} {}", html::number(interval[1]), unit) : "none seen";
}

/// Empty where no sensor of the kind ("gyro", "accel") has a deviation.
std::string allan_figure(std::string_view kind, const json& sensors) {
  for (const auto& [name, document] : sensors.items()) {
    if (!name.starts_with(kind) || !member(document, "tau_s").is_array()) continue;
    return figure("allan", kind,
                  {fmt::format("Allan deviation of the {}", kind == "gyro" ? "gyros" : "accelerometers"),
                   "Overlapping Allan deviation over averaging time, both axes logarithmic; the table has the noise "
                   "coefficients."});
  }
  return {};
}

std::string coefficients_table(std::string_view kind, const json& sensors) {
  std::vector<std::string> headings = {"term"};
  std::vector<const json*> documents;
  for (const auto& [name, document] : sensors.items()) {
    if (!name.starts_with(kind) || member(document, "coefficients").empty()) continue;
    headings.push_back(name);
    documents.push_back(&document);
  }
  if (documents.empty()) return {};
  html::Table table("Noise coefficients with 95 % intervals", headings);
  for (const Term& term : kTerms) {
    std::vector<html::Cell> cells = {html::row_heading(term.name)};
    for (const json* document : documents) {
      cells.push_back(html::html_cell(coefficient_text(member((*document)["coefficients"], term.key))));
    }
    table.row(cells);
  }
  return table.html();
}

/// What must be said of the sensors' noise: reasons why there is none, warnings.
std::string noise_remarks(const json& sensors) {
  std::string html;
  for (const auto& [name, document] : sensors.items()) {
    if (document.contains("reason")) {
      html += fmt::format("<li>{}: {}</li>\n", html::escaped(name), html::text_of(document, "reason"));
    }
    for (const json& warning : member(document, "warnings")) {
      html += fmt::format("<li>{}: {}</li>\n", html::escaped(name), html::text_of(warning, "text"));
    }
  }
  return html.empty() ? "" : "<ul>\n" + html + "</ul>\n";
}

std::string segment_words(const json& noise) {
  const json& segment = noise["segment"];
  double used_s = 0.0;
  for (const auto& [name, document] : noise["sensors"].items()) {
    if (document.contains("samples")) used_s = document["samples"].get<double>() / document["rate_hz"].get<double>();
  }
  const double length_s = segment["duration_s"];
  const std::string position = segment["position"];
  return fmt::format(
      "<p>From the longest segment at rest: run {} of campaign {}, visit {}, {}, {} °C, {} long{}{}. Averaging times "
      "end with the segment: slower effects cannot be seen.{}</p>\n",
      html::text_of(segment, "run"), html::text_of(segment, "campaign"), html::text_of(segment, "visit"),
      position.empty() ? "one attitude" : "position " + html::escaped(position),
      segment["temp_c"].is_number() ? html::number(segment["temp_c"].get<double>(), 1) : "–", html::duration(length_s),
      used_s > 0.0 && used_s < 0.95 * length_s ? ", its first " + html::duration(used_s) : "",
      segment["simulated"].get<bool>() ? ", SIMULATED" : "",
      segment["plateau_c"].is_null()
          ? " The temperature was not held constant: its effect on the sensor looks like slow noise."
          : "");
}

std::string waiver_text(const json& reference) {
  const json& waiver = member(reference, "waiver");
  if (!waiver.is_object()) return "–";
  return fmt::format("signed by {} on {}: {}", html::text_of(waiver, "signer"), html::text_of(waiver, "signed_utc"),
                     html::text_of(waiver, "reason"));
}

std::string references_table(const json& references) {
  html::Table table("References that the campaigns were measured with",
                    {"kind", "name", "certificate", "correction", "standard uncertainty", "what it affects", "due",
                     "waiver", "since then"});
  for (const json& reference : references) {
    const auto kind = calib::reference_kind_named(reference.value("kind", ""));
    const std::string unit = html::unit_text(reference.value("unit", ""));
    const json& correction = member(reference, "correction");
    table.row({html::html_cell(html::text_of(reference, "kind")), html::html_cell(html::text_of(reference, "name")),
               html::html_cell(html::text_of(reference, "certificate")),
               html::html_cell(correction.is_number() ? html::number(correction) + " " + unit : "–", true),
               html::html_cell(html::number(member(reference, "standard_uncertainty")) + " " + unit, true),
               html::text_cell(kind ? calib::bears_on(*kind) : "–"),
               html::html_cell(html::text_of(reference, "due_utc")), html::html_cell(waiver_text(reference)),
               html::html_cell(member(reference, "since").is_string() ? html::text_of(reference, "since") : "–")});
  }
  return table.html();
}

}  // namespace

std::string couplings_part(const json& couplings) {
  std::string html = "<section id=\"couplings\"><h2>Misalignment and g-sensitivity</h2>\n";
  const json& misalignment = member(couplings, "accel_misalignment_rad");
  const json& of_gyros = member(couplings, "gyro_misalignment_rad");
  const json& sensitivity = member(couplings, "g_sensitivity_dps_per_g");
  html += "<div class=\"tables\">\n";
  if (misalignment.is_object()) {
    html += coupling_table("Accelerometer misalignment, mrad ± standard error", misalignment, "accel", kMillirad);
  }
  if (of_gyros.is_object()) {
    html += coupling_table("Misalignment of the gyros, mrad ± standard error", of_gyros, "gyro", kMillirad);
  }
  if (sensitivity.is_object()) {
    html += coupling_table("g-sensitivity of the gyros, °/s per g ± standard error", sensitivity, "gyro", 1.0);
  }
  html += even_order_table(member(couplings, "accel_even_order_g_per_g2")) + "</div>\n";
  html += misalignment.is_object() ? "<p>Misalignment is one constant for all temperatures, mean over runs, and in the "
                                     "file. A constant tilt of the fixture looks the same." +
                                         type_b_words(misalignment) + "</p>\n"
                                   : "<p>Misalignment: not known: the positions do not determine all of it.</p>\n";
  if (of_gyros.is_object()) {
    html +=
        "<p>Misalignment of the gyros is from movements between rests, against the axes of the accelerometers, and in "
        "the file.</p>\n";
  }
  html +=
      sensitivity.is_object()
          ? "<p>g-sensitivity is reported only here and is not in the file" +
                std::string(
                    member(couplings, "earth_rate_subtracted") == "whole"
                        ? "; the whole rotation of the Earth was subtracted.</p>\n"
                        : "; its off-diagonal terms also contain the horizontal part of the Earth's rotation.</p>\n")
          : "<p>g-sensitivity: not known: the positions do not determine all of it.</p>\n";
  html += level_words(member(couplings, "level_error"));
  return html + "</section>\n";
}

std::string noise_part(const json& noise) {
  std::string html = "<section id=\"noise\"><h2>Noise</h2>\n";
  if (noise["segment"].is_null()) {
    return html + fmt::format("<p>Not known: {}.</p></section>\n", html::text_of(noise, "reason"));
  }
  const json& sensors = noise["sensors"];
  html += segment_words(noise);
  html += "<div class=\"figures\">\n" + allan_figure("gyro", sensors) + allan_figure("accel", sensors) + "</div>\n";
  html += coefficients_table("gyro", sensors) + coefficients_table("accel", sensors) + noise_remarks(sensors);
  return html + "</section>\n";
}

std::string records_part(const json& records) {
  std::string html = "<section id=\"records\"><h2>Records of the laboratory</h2>\n";
  const json& references = records["references"];
  if (references.is_array() && !references.empty()) return html + references_table(references) + "</section>\n";
  return html + (references.is_array() ? "<p>No reference was entered for the campaigns of this model: nothing here is "
                                         "traceable to a certificate.</p></section>\n"
                                       : "<p>Not stated: the model was stored by a version of Soak without a register "
                                         "of references.</p></section>\n");
}

}  // namespace soak::station
