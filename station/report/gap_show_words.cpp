// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "station/report/gap_words.h"

namespace soak::station {
namespace {

using calib::ModelTerm;
using calib::Sensor;

bool acts_on(const GapComparison& comparison, Sensor sensor) {
  return std::ranges::any_of(comparison.terms, [&](const ModelTerm& term) { return term.part_of(sensor) != nullptr; });
}

/// The sensors that an effect acts on and fresh runs have readings of.
std::vector<Sensor> judged_sensors(const GapComparison& comparison) {
  std::vector<Sensor> sensors;
  for (const Sensor sensor : calib::kSensors) {
    if (comparison.fresh[calib::index_of(sensor)] && acts_on(comparison, sensor)) sensors.push_back(sensor);
  }
  return sensors;
}

/// Of these the one in which the gap has changed most.
Sensor most_changed(const GapComparison& comparison, const std::vector<Sensor>& sensors) {
  const auto change = [&](Sensor sensor) {
    const SensorComparison& fresh = *comparison.fresh[calib::index_of(sensor)];
    return std::abs(std::log(fresh.after_rms / fresh.before_rms));
  };
  return *std::ranges::max_element(sensors, {}, change);
}

std::size_t fresh_runs(const GapComparison& comparison) {
  return static_cast<std::size_t>(std::ranges::count_if(comparison.runs, [](const auto& run) { return !run.fitted; }));
}

std::size_t closer_sensors(const GapComparison& comparison, const std::vector<Sensor>& sensors) {
  return static_cast<std::size_t>(std::ranges::count_if(sensors, [&](Sensor sensor) {
    const SensorComparison& fresh = *comparison.fresh[calib::index_of(sensor)];
    return fresh.after_rms < fresh.before_rms;
  }));
}

/// What fresh runs say of the sensor in which the gap has changed most, and in how many it is smaller.
std::string closed_words(const GapComparison& comparison, const std::vector<Sensor>& sensors) {
  const Sensor most = most_changed(comparison, sensors);
  const SensorComparison& fresh = *comparison.fresh[calib::index_of(most)];
  const double factor = calib::printed_per_si(most);
  const std::size_t runs = fresh_runs(comparison);
  const std::string closed = fresh.closed_fraction
                                 ? fmt::format("{:.0f} % of it is closed", 100.0 * *fresh.closed_fraction)
                                 : std::string("how much of it is closed is too small to tell");
  return fmt::format(
      "On {} that no fit has seen the gap of {} went from {:.3g} to {:.3g} {}{}: {}; it is smaller in {} of {} "
      "sensors.",
      runs == 1 ? "1 run" : fmt::format("{} runs", runs), calib::name_of(most), fresh.before_rms * factor,
      fresh.after_rms * factor, calib::printed_unit(most),
      fresh.floor_rms ? fmt::format(" (noise leaves {:.3g})", *fresh.floor_rms * factor) : "", closed,
      closer_sensors(comparison, sensors), sensors.size());
}

/// Whether the effects have made it better on fresh runs: smaller gaps in half of the sensors or more, none worse.
bool has_helped(const GapComparison& comparison, const std::vector<Sensor>& sensors) {
  const bool worse =
      std::ranges::any_of(sensors, [&](Sensor sensor) { return is_worse(*comparison.fresh[calib::index_of(sensor)]); });
  return !worse && 2 * closer_sensors(comparison, sensors) >= sensors.size();
}

/// The model carries no effect.
ThreeSentences without_terms(const GapComparison& comparison) {
  return {fmt::format("Unit {}: model {} contains no accepted effect, so before and after are the same.",
                      comparison.unit, comparison.model),
          fmt::format("{}The figures below say how far it is from what was measured.",
                      fresh_runs(comparison) == 0 ? "No run is fresh: all were fitted. " : ""),
          fmt::format("Next: 'soak gap find --unit {}' looks for what it lacks.", comparison.unit)};
}

std::string withdraw_command(const GapComparison& comparison) {
  return fmt::format("'soak gap withdraw --unit {} --effect {} --reason TEXT'", comparison.unit,
                     comparison.terms.back().name);
}

}  // namespace

std::string terms_words(const std::vector<ModelTerm>& terms, const std::vector<std::vector<std::string>>& lines) {
  std::vector<std::string> list;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    list.push_back(fmt::format("{} ({})", effect_words(terms[t].name), fmt::join(lines.at(t), "; ")));
  }
  return fmt::format("{}", fmt::join(list, "; and "));
}

ThreeSentences sentences_of(const GapComparison& comparison, const std::string& effects) {
  if (comparison.terms.empty()) return without_terms(comparison);
  const std::string what = fmt::format("Unit {}: model {} takes off what model {} does not: {}.", comparison.unit,
                                       comparison.model, comparison.before, effects);
  const std::vector<Sensor> sensors = judged_sensors(comparison);
  if (sensors.empty()) {
    return {what,
            "Nothing is proved yet: no fresh run shows the sensors that it acts on, and a model looks too good on runs "
            "that "
            "it was fitted to.",
            fmt::format("Next: record a run with a procedure whose purpose is verification, then 'soak gap show --unit "
                        "{}' again.",
                        comparison.unit)};
  }
  if (std::ranges::none_of(comparison.terms, [](const ModelTerm& term) { return moves_blocks(term.name); })) {
    return {what, "It shows in single readings, not in the means that are compared here: the gap stays as it is.",
            fmt::format("Next: judge model {} on fresh runs: 'soak verify --unit {} --campaign NAME'.",
                        comparison.model, comparison.unit)};
  }
  if (has_helped(comparison, sensors)) {
    return {what, closed_words(comparison, sensors),
            fmt::format("Next: judge model {0} on fresh runs and release it: 'soak verify --unit {1} --campaign NAME', "
                        "'soak release --unit {1}'.",
                        comparison.model, comparison.unit)};
  }
  return {
      what, closed_words(comparison, sensors),
      fmt::format("Next: the effect does not hold on fresh runs, so take it out: {}.", withdraw_command(comparison))};
}

}  // namespace soak::station
