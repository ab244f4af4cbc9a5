// SPDX-License-Identifier: Apache-2.0
#include "station/report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "calib/model/document_parts.h"
#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using calib::forward::SimulatedCampaign;
using nlohmann::json;

struct Mean {
  double count = 0.0;
  double value = 0.0;
  double temp_c = 0.0;
  calib::Sweep sweep = calib::Sweep::unknown;

  void add(double v, double c) {
    count += 1.0;
    value += (v - value) / count;
    temp_c += (c - temp_c) / count;
  }
};

/// What was read beyond the simulation, less the run's own mean, as [temperature, value]: one point per segment, and
/// the mean of each visit by the way it was reached.
json residual_marks(const SimulatedCampaign& campaign, const std::vector<ComparedRun>& runs, std::size_t s,
                    double factor) {
  std::map<std::pair<int, std::size_t>, Mean> segments;
  std::map<std::pair<int, int>, Mean> visits;
  std::map<int, Mean> of_run;
  for (const auto& block : campaign.blocks) {
    if (!block.measured[s] || !block.simulated[s]) continue;
    const double off = factor * (*block.measured[s] - *block.simulated[s]);
    segments[{block.run, block.segment}].add(off, block.temp_c);
    Mean& visit = visits[{block.run, block.visit}];
    visit.sweep = block.sweep;
    visit.add(off, block.temp_c);
    of_run[block.run].add(off, block.temp_c);
  }
  json marks;
  for (const char* key : {"segments", "up", "down", "other", "fresh"}) marks[key] = json::array();
  for (const auto& [key, segment] : segments) {
    marks["segments"].push_back({segment.temp_c, segment.value - of_run[key.first].value});
  }
  for (const auto& [key, visit] : visits) {
    const char* kind = !runs[static_cast<std::size_t>(key.first)].fitted ? "fresh"
                       : visit.sweep == calib::Sweep::up                 ? "up"
                       : visit.sweep == calib::Sweep::down               ? "down"
                                                                         : "other";
    marks[kind].push_back({visit.temp_c, visit.value - of_run[key.first].value});
  }
  return marks;
}

/// What the figure of one sensor is drawn from: one panel, or the two of before and after where an effect was accepted.
json gap_data(const GapComparison& comparison, calib::Sensor sensor) {
  const auto& blocks = comparison.simulated_before.blocks;
  const auto [coldest, warmest] =
      std::ranges::minmax_element(blocks, {}, [](const auto& block) { return block.temp_c; });
  const bool both = !comparison.terms.empty();
  const auto panel = [&](const std::string& name, const SimulatedCampaign& campaign) {
    return json{
        {"name", name},
        {"marks", residual_marks(campaign, comparison.runs, calib::index_of(sensor), calib::printed_per_si(sensor))}};
  };
  json data = {{"unit", html::unit_text(calib::printed_unit(sensor))},
               {"temp_min_c", coldest->temp_c - 2.0},
               {"temp_max_c", warmest->temp_c + 2.0},
               {"panels", json::array()}};
  data["panels"].push_back(
      panel(fmt::format("model {}{}", comparison.before, both ? ", before" : ""), comparison.simulated_before));
  if (both) {
    data["panels"].push_back(panel(fmt::format("model {}, after", comparison.model), comparison.simulated_after));
  }
  return data;
}

std::string gap_figure(calib::Sensor sensor) {
  return figure("gap", calib::name_of(sensor),
                {fmt::format("{}: measured minus simulated", calib::name_of(sensor)),
                 "Measured minus simulated, over temperature: faint marks per position, solid ones per visit, each "
                 "run's own mean removed; where an effect was accepted, before above and after below."});
}

/// Sensors that an accepted effect acts on, then the others.
std::vector<calib::Sensor> in_order_of_interest(const GapComparison& comparison) {
  std::vector<calib::Sensor> sensors;
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    if (comparison.fitted[s] || comparison.fresh[s]) sensors.push_back(sensor);
  }
  std::stable_partition(sensors.begin(), sensors.end(), [&](calib::Sensor sensor) {
    return std::any_of(comparison.terms.begin(), comparison.terms.end(),
                       [&](const calib::ModelTerm& term) { return term.part_of(sensor) != nullptr; });
  });
  return sensors;
}

html::Cell closed_cell(const std::optional<double>& fraction) {
  if (!fraction) return html::text_cell("too small to tell");
  return html::html_cell(html::number(100.0 * *fraction, 0) + " %", true);
}

std::string figures(const GapComparison& comparison) {
  html::Table table("RMS of measured minus simulated, about each run's own mean",
                    {"Sensor", "Unit", "Runs", "Before", "After", "Floor", "Noise alone", "Closed"});
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    const double factor = calib::printed_per_si(sensor);
    for (const auto& [part, name] :
         {std::pair(&comparison.fitted[s], "fitted"), std::pair(&comparison.fresh[s], "fresh")}) {
      if (!*part) continue;
      const SensorComparison& row = **part;
      table.row({html::row_heading(calib::name_of(sensor)),
                 html::text_cell(html::unit_text(calib::printed_unit(sensor))), html::text_cell(name),
                 html::number_cell(row.before_rms * factor), html::number_cell(row.after_rms * factor),
                 row.floor_rms ? html::number_cell(*row.floor_rms * factor) : html::text_cell("–"),
                 html::number_cell(row.noise_rms * factor),
                 part == &comparison.fitted[s] ? html::text_cell("–") : closed_cell(row.closed_fraction)});
    }
  }
  return table.html();
}

std::string remarks_part(const GapComparison& comparison) {
  std::string items;
  for (const std::string& sentence : remarks(comparison))
    items += fmt::format("<li>{}</li>\n", html::escaped(sentence));
  return items.empty() ? "" : "<ul>\n" + items + "</ul>\n";
}

/// Slow noise, sensor by sensor, beside the bias instability at rest; empty without any.
std::string slow_noise_part(const std::vector<calib::gap::SensorWander>& wanders) {
  if (wanders.empty()) return {};
  html::Table table("Slow noise: how the bias wanders while the unit runs, as the search before found it",
                    {"Sensor", "Unit", "Standard deviation within a run", "Forgotten within minutes", "Within hours",
                     "Bias instability B at rest (95 %)"});
  for (const calib::gap::SensorWander& wander : wanders) {
    const double factor = calib::printed_per_si(wander.sensor);
    const auto percent = [](double share) { return html::html_cell(html::number(100.0 * share, 0) + " %", true); };
    const auto& rest = wander.at_rest;
    table.row({html::row_heading(calib::name_of(wander.sensor)),
               html::text_cell(html::unit_text(calib::printed_unit(wander.sensor))),
               html::number_cell(wander.within_run * factor), percent(wander.share_minutes),
               percent(wander.share_hours),
               rest ? html::html_cell(fmt::format("{} ({} to {}), run {}", html::number(rest->value * factor),
                                                  html::number(rest->low * factor), html::number(rest->high * factor),
                                                  html::escaped(rest->run)))
                    : html::text_cell("–")});
  }
  return "<section id=\"slow-noise\"><h2>Slow noise</h2>\n" + table.html() + "</section>\n";
}

std::string introduction(const GapComparison& comparison, const ThreeSentences& sentences) {
  std::size_t fresh = 0;
  for (const ComparedRun& run : comparison.runs) fresh += run.fitted ? 0 : 1;
  std::string first;
  for (const std::string& sentence : sentences) first += "<p>" + html::escaped(sentence) + "</p>\n";
  return fmt::format(
      "<h1>Simulation and measurement, unit {}</h1>\n<div id=\"result\">{}</div>\n<p>Each run was simulated from its "
      "own log of temperature, "
      "positions and place: with model {} (before) and with model {} (after its accepted effects). The gap is what the "
      "unit measured minus what was simulated. {} runs, {} of them fresh: neither model was fitted to those. "
      "<b>Floor</b> is what noise and run-to-run scatter would leave with a perfect model, <b>noise alone</b> what the "
      "noise of the samples would leave. Fitted runs lie below the floor, because the fit follows part of their "
      "noise.</p>\n",
      html::escaped(comparison.unit), first, comparison.before, comparison.model, comparison.runs.size(), fresh);
}

}  // namespace

std::string gap_page(const GapComparison& comparison, const ThreeSentences& sentences, const std::string& software,
                     double created_utc_s) {
  std::string body = introduction(comparison, sentences) + "<section id=\"figures\"><h2>Figures</h2>\n" +
                     figures(comparison) + remarks_part(comparison) +
                     "</section>\n<section id=\"pictures\"><h2>Pictures</h2>\n";
  json data = {{"sensors", json::object()}};
  if (!comparison.simulated_before.blocks.empty()) {
    body += "<div class=\"figures\">\n";
    for (const calib::Sensor sensor : in_order_of_interest(comparison)) {
      body += gap_figure(sensor);
      data["sensors"][std::string(calib::name_of(sensor))] = gap_data(comparison, sensor);
    }
    body += "</div>\n";
  }
  body += "</section>\n" + slow_noise_part(comparison.slow_noise) + terms_part(calib::terms_json(comparison.terms));
  const std::string title = fmt::format("{}Gap of unit {}, models {} and {}", comparison.simulated ? "SIMULATED: " : "",
                                        comparison.unit, comparison.before, comparison.model);
  return page_frame({title, software, created_utc_s, comparison.simulated}, body, data);
}

}  // namespace soak::station
