// SPDX-License-Identifier: Apache-2.0
#include "station/report/gap_page.h"

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
#include "station/report/svg.h"

namespace soak::station {
namespace {

using calib::forward::SimulatedCampaign;
using svg::Mark;
using svg::Point;

constexpr double kWidth = 520.0;
constexpr double kPanel = 190.0;
constexpr double kLeft = 66.0;
constexpr double kTop = 26.0;
constexpr double kGap = 36.0;

/// What was read beyond the simulation, less the run's own mean: one faint point per segment, and the mean of each
/// visit by the way it was reached.
struct Residuals {
  std::vector<Point> segments;
  std::vector<Point> up;
  std::vector<Point> down;
  std::vector<Point> other;
  std::vector<Point> fresh;

  [[nodiscard]] double largest() const {
    double most = 0.0;
    for (const auto* points : {&segments, &up, &down, &other, &fresh}) {
      for (const Point& point : *points) most = std::max(most, std::abs(point.y));
    }
    return most;
  }
};

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

Residuals residuals_of(const SimulatedCampaign& campaign, const std::vector<ComparedRun>& runs, std::size_t s,
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
  Residuals result;
  for (const auto& [key, segment] : segments) {
    result.segments.push_back({segment.temp_c, segment.value - of_run[key.first].value});
  }
  for (const auto& [key, visit] : visits) {
    const Point point{visit.temp_c, visit.value - of_run[key.first].value};
    if (!runs[static_cast<std::size_t>(key.first)].fitted) {
      result.fresh.push_back(point);
    } else {
      (visit.sweep == calib::Sweep::up     ? result.up
       : visit.sweep == calib::Sweep::down ? result.down
                                           : result.other)
          .push_back(point);
    }
  }
  return result;
}

void draw(svg::Panel& panel, const Residuals& residuals) {
  panel.marks(residuals.segments, Mark::dot, "faint");
  panel.level(0.0, "curve");
  panel.marks(residuals.other, Mark::dot, "c2");
  panel.marks(residuals.up, Mark::up, "c0");
  panel.marks(residuals.down, Mark::down, "c1");
  panel.marks(residuals.fresh, Mark::square, "fresh");
}

std::pair<double, double> temperature_range(const SimulatedCampaign& campaign) {
  double low = campaign.blocks.front().temp_c;
  double high = low;
  for (const auto& block : campaign.blocks) {
    low = std::min(low, block.temp_c);
    high = std::max(high, block.temp_c);
  }
  return {low - 2.0, high + 2.0};
}

/// One panel, or the two of before and after where an effect was accepted.
std::string panels(const GapComparison& comparison, const Residuals& before, const Residuals& after,
                   std::string_view unit, svg::Drawing& drawing) {
  const double most = std::max({1.05 * before.largest(), 1.05 * after.largest(), 1e-12});
  const auto [low_c, high_c] = temperature_range(comparison.simulated_before);
  const svg::Scale x{low_c, high_c};
  const svg::Scale y{-most, most};
  constexpr std::string_view kTemperature = "temperature (°C)";
  const bool both = !comparison.terms.empty();
  svg::Panel upper({kLeft, kTop, kWidth - 12.0, kTop + kPanel}, x, y);
  upper.axes(both ? "" : kTemperature, fmt::format("model {}{} ({})", comparison.before, both ? ", before" : "", unit));
  draw(upper, before);
  drawing.height = kTop + kPanel + 42.0;
  if (!both) return upper.svg();
  const double second = kTop + kPanel + kGap;
  svg::Panel lower({kLeft, second, kWidth - 12.0, second + kPanel}, x, y);
  lower.axes(kTemperature, fmt::format("model {}, after ({})", comparison.model, unit));
  draw(lower, after);
  drawing.height = second + kPanel + 42.0;
  return upper.svg() + lower.svg();
}

std::string chart(const GapComparison& comparison, calib::Sensor sensor) {
  const std::size_t s = calib::index_of(sensor);
  const double factor = calib::printed_per_si(sensor);
  const Residuals before = residuals_of(comparison.simulated_before, comparison.runs, s, factor);
  const Residuals after = residuals_of(comparison.simulated_after, comparison.runs, s, factor);
  svg::Drawing drawing;
  drawing.id = fmt::format("gap-{}", calib::name_of(sensor));
  drawing.title = fmt::format("{}: read beyond the simulation", calib::name_of(sensor));
  drawing.description =
      "Measured less simulated over temperature: faint marks per position, full ones per visit, each run's own mean "
      "taken off; where an effect was accepted, before above and after below.";
  drawing.width = kWidth;
  drawing.content = panels(comparison, before, after, html::unit_text(calib::printed_unit(sensor)), drawing);
  drawing.legend = {{"run faint", "one position"}, {"run c0", "heating"}, {"run c1", "cooling"}};
  if (!before.other.empty()) drawing.legend.push_back({"run c2", "first plateau"});
  if (!before.fresh.empty()) drawing.legend.push_back({"square fresh", "fresh runs"});
  return svg::figure(drawing);
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
  html::Table table("RMS of what was read beyond the simulation, about each run's own mean",
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

std::string introduction(const GapComparison& comparison) {
  std::size_t fresh = 0;
  for (const ComparedRun& run : comparison.runs) fresh += run.fitted ? 0 : 1;
  return fmt::format(
      "<h1>Simulation and measurement, unit {}</h1>\n<p>Each run was simulated from its own log of temperature, "
      "positions and place: with model {} (before) and with model {} (after its accepted effects). What the unit read "
      "beyond that is the gap. {} runs, {} of them fresh: neither model was fitted to those. <b>Floor</b> is what "
      "noise "
      "and the scatter between runs would leave of a perfect model, <b>noise alone</b> what the samples' noise "
      "leaves. Fitted runs lie below the floor by what the fit took of their noise.</p>\n",
      html::escaped(comparison.unit), comparison.before, comparison.model, comparison.runs.size(), fresh);
}

}  // namespace

std::string gap_page(const GapComparison& comparison, const std::string& software, double created_utc_s) {
  std::string body = introduction(comparison) + "<section id=\"figures\"><h2>Figures</h2>\n" + figures(comparison) +
                     remarks_part(comparison) + "</section>\n<section id=\"pictures\"><h2>Pictures</h2>\n";
  if (!comparison.simulated_before.blocks.empty()) {
    body += "<div class=\"figures\">\n";
    for (const calib::Sensor sensor : in_order_of_interest(comparison)) body += chart(comparison, sensor);
    body += "</div>\n";
  }
  body += "</section>\n" + terms_part(calib::terms_json(comparison.terms));
  const std::string title = fmt::format("{}Gap of unit {}, models {} and {}", comparison.simulated ? "SIMULATED: " : "",
                                        comparison.unit, comparison.before, comparison.model);
  return page_frame(title, body, software, nlohmann::json(created_utc_s), comparison.simulated);
}

}  // namespace soak::station
