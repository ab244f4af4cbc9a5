// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "calib/gap/report/gap_json.h"
#include "calib/gap/report/gap_report.h"
#include "station/commands/gap_commands.h"
#include "station/gap/gap_search.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

using calib::gap::GapReport;
using calib::gap::NamedEffect;

std::string sensors_text(const std::vector<calib::Sensor>& sensors) {
  std::vector<std::string_view> names;
  for (const calib::Sensor sensor : sensors) names.push_back(calib::name_of(sensor));
  return sensors.size() == calib::kSensorCount ? "all sensors" : fmt::format("{}", fmt::join(names, ", "));
}

std::string effect_text(const NamedEffect& effect, const std::string& next_experiment) {
  std::string text = fmt::format("  {}: {:.3g} {}{}{}, {}\n    {}\n    chance that scatter looks like it: {:.2g}\n",
                                 effect.effect->name, effect.magnitude.value, effect.magnitude.unit,
                                 effect.candidate.shape.empty() ? "" : ", ", effect.candidate.shape,
                                 sensors_text(effect.sensors), effect.effect->physics, effect.p_adjusted);
  if (!effect.rivals.empty()) {
    std::vector<std::string_view> names;
    for (const auto* rival : effect.rivals) names.push_back(rival->name);
    text += fmt::format("    nearly as good: {}\n", fmt::join(names, ", "));
  }
  if (!next_experiment.empty()) {
    text += fmt::format("    next experiment: {}\n", next_experiment);
  }
  return text;
}

std::string gap_table(const GapReport& report) {
  std::vector<std::vector<std::string>> table = {
      {"sensor", "unit", "before", "after", "floor", "closed", "95 %", "at the gate"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& gap = report.gap[calib::index_of(sensor)];
    const auto& limit = report.detection_limit[calib::index_of(sensor)];
    if (!gap) continue;
    const double factor = calib::printed_per_si(sensor);
    table.push_back({std::string(calib::name_of(sensor)), std::string(calib::printed_unit(sensor)),
                     fmt::format("{:.3g}", gap->before_rms * factor), fmt::format("{:.3g}", gap->after_rms * factor),
                     fmt::format("{:.3g}", gap->floor_rms * factor),
                     gap->closed_fraction ? fmt::format("{:.0f} %", 100.0 * *gap->closed_fraction)
                     : report.held_out == calib::gap::HeldOut::runs ? "too small to tell"
                                                                    : "-",
                     gap->closed_ci95 ? fmt::format("{:.0f}..{:.0f} %", 100.0 * gap->closed_ci95->first,
                                                    100.0 * gap->closed_ci95->second)
                                      : "-",
                     limit ? fmt::format("{:.2g}", *limit * factor) : "-"});
  }
  return text_table(table);
}

std::string_view unseen(calib::gap::HeldOut held_out) {
  return held_out == calib::gap::HeldOut::runs       ? "runs"
         : held_out == calib::gap::HeldOut::branches ? "branches"
                                                     : "halves of the branches' difference";
}

/// Of the data gate, a line for each run and sensor.
std::string left_out_text(const GapReport& report) {
  std::string text;
  for (const calib::gap::LeftOut& entry : report.left_out) {
    text += fmt::format("left out by the data gate: run {}{}: {} of {} segments ({}): {}\n", entry.run,
                        entry.sensor ? fmt::format(", {}", calib::name_of(*entry.sensor)) : "", entry.segments,
                        entry.of, entry.code, entry.why);
  }
  return text;
}

std::string describe(const GapReport& report) {
  std::string text = fmt::format("unit {}, model {}: {}\n{}\n", report.unit, report.model,
                                 calib::gap::name_of(report.verdict), report.reason);
  for (std::size_t e = 0; e < report.effects.size(); ++e) {
    text += effect_text(report.effects[e], report.next.at(e).text);
  }
  if (!report.suspects.empty()) {
    text += "no name is given to:\n";
    for (const NamedEffect& effect : report.suspects) text += effect_text(effect, "");
  }
  if (report.verdict != calib::gap::Verdict::cannot_judge) {
    text += fmt::format("\ngap on {} that neither base nor parameters have seen (RMS of {} means):\n{}",
                        unseen(report.held_out),
                        report.held_out == calib::gap::HeldOut::runs ? "one-minute" : "30-second", gap_table(report));
  }
  for (const auto& entry : report.not_testable) text += fmt::format("not testable: {}: {}\n", entry.name, entry.why);
  return text + left_out_text(report);
}

}  // namespace

base::Status run_gap_find(const GapFindCommand& command, Output& output) {
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto search = search_gap(*catalog, command.unit, command.campaign);
  if (!search) return base::forward_error(search);
  const nlohmann::json document = calib::gap::gap_json(search->report);
  if (auto stored = catalog->add_gap_report({command.unit, search->model.version, now_utc_s(), document.dump()});
      !stored) {
    return stored;
  }
  for (const std::string& sentence : search->not_taken_off) output.note("warning: " + sentence);
  if (output.json()) return output.print_json(document);
  output.print(describe(search->report));
  return {};
}

}  // namespace soak::station
