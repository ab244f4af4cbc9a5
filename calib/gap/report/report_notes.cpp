// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/report_notes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

namespace soak::calib::gap {
namespace {

/// Whether each position always comes after the same one: what it remembers of that is then a constant of its own.
bool one_order(const Observations& observations) {
  std::map<int, int> before;
  for (const Observation& row : observations.rows) {
    if (row.position < 0 || row.previous < 0) continue;
    if (before.try_emplace(row.position, row.previous).first->second != row.previous) return false;
  }
  return before.size() > 1;
}

}  // namespace

void add_note(GapReport& report, std::string code, std::string text) {
  report.reason += "; " + text;
  report.notes.push_back({std::move(code), std::move(text)});
}

void note_sensors_without_scatter(const Observations& observations, const CampaignModel& model, GapReport& report) {
  std::vector<Sensor> sensors;
  for (const Sensor sensor : kSensors) {
    const bool recorded = std::any_of(observations.rows.begin(), observations.rows.end(),
                                      [&](const Observation& row) { return row.sensor[index_of(sensor)].count > 0; });
    if (recorded && !model.residuals().sensor[index_of(sensor)]) sensors.push_back(sensor);
  }
  if (sensors.empty()) return;
  add_note(report, "no_scatter", "not judged, as their readings do not scatter: " + list_of(sensors));
}

void note_wander(GapReport& report) {
  std::vector<std::string> sizes;
  for (const SensorWander& wander : report.slow_noise) {
    sizes.push_back(fmt::format("{} {:.2g} {}", name_of(wander.sensor),
                                wander.within_run * printed_per_si(wander.sensor), printed_unit(wander.sensor)));
  }
  add_note(report, "wandering_bias",
           fmt::format("the bias wanders while the unit runs, in another way in each run, as bias instability and rate "
                       "random walk do; that is counted as noise: {} (standard deviation within a run)",
                       fmt::join(sizes, ", ")));
}

void note_position_order(const Observations& observations, GapReport& report) {
  constexpr std::array<std::string_view, 3> kOfPosition = {"g_sensitivity", "earth_rate", "scale_nonlinearity"};
  const bool concerned = std::any_of(report.effects.begin(), report.effects.end(), [&](const NamedEffect& named) {
    return std::find(kOfPosition.begin(), kOfPosition.end(), named.effect->name) != kOfPosition.end();
  });
  const bool told = std::any_of(report.effects.begin(), report.effects.end(),
                                [](const NamedEffect& named) { return named.effect->name == "position_memory"; });
  if (!concerned || told || !one_order(observations)) return;
  add_note(report, "position_order",
           "the positions always came in the same order: creep, or memory of the previous position, could look the "
           "same; a run in another order would decide");
}

void note_thermometer(const LoggedCampaign& campaign, const TemperatureHistory& history, GapReport& report) {
  if (const auto& fine = campaign.fine_temperature) {
    add_note(
        report, "reconstructed_temperature",
        fmt::format("temperatures within the thermometer's steps of {:.2g} K were reconstructed from the chamber's "
                    "air, which the unit follows with time constants of {:.0f} s and {:.0f} s; they are right to "
                    "{:.2f} K where the reading changes",
                    fine->step_c, fine->tau_s[0], fine->tau_s[1], fine->error_c));
    return;
  }
  if (const auto& coarse = history.coarse()) {
    add_note(report, "coarse_thermometer", fmt::format("what changes with time was not looked for: {}", *coarse));
  }
}

}  // namespace soak::calib::gap
