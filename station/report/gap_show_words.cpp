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

/// What fresh runs say of the effects that a model contains.
enum class FreshOutcome { helped, worse, not_shown };

/// Worse: in any sensor that was recorded. Helped: better in half or more of the sensors in which there was more than
/// noise to close.
FreshOutcome outcome_of(const GapComparison& comparison, const std::vector<Sensor>& sensors) {
  if (std::ranges::any_of(comparison.fresh, [](const auto& fresh) { return fresh && is_worse(*fresh); })) {
    return FreshOutcome::worse;
  }
  const auto fresh = [&](Sensor sensor) { return *comparison.fresh[calib::index_of(sensor)]; };
  const auto better = std::ranges::count_if(sensors, [&](Sensor sensor) { return is_better(fresh(sensor)); });
  const auto open =
      std::ranges::count_if(sensors, [&](Sensor sensor) { return fresh(sensor).closed_fraction.has_value(); });
  return better > 0 && 2 * better >= open ? FreshOutcome::helped : FreshOutcome::not_shown;
}

/// Whether an effect acts on a sensor of which `test` holds, on fresh runs.
template <typename Test>
bool acts_where(const GapComparison& comparison, const ModelTerm& term, const Test& test) {
  return std::ranges::any_of(calib::kSensors, [&](Sensor sensor) {
    const auto& fresh = comparison.fresh[calib::index_of(sensor)];
    return fresh && test(*fresh) && term.part_of(sensor) != nullptr;
  });
}

/// Names of the effects that fresh runs show and that act on a sensor that has become worse: those of them that make
/// nothing better, if there are such.
std::vector<std::string> blamed(const GapComparison& comparison) {
  std::vector<std::string> all;
  std::vector<std::string> only_worse;
  for (const ModelTerm& term : comparison.terms) {
    if (!acts_where(comparison, term, is_worse) || shown_by_fresh_runs(term.name) == ShownPart::nothing) continue;
    if (std::ranges::find(all, term.name) != all.end()) continue;
    all.push_back(term.name);
    if (!acts_where(comparison, term, is_better)) only_worse.push_back(term.name);
  }
  return only_worse.empty() ? all : only_worse;
}

/// The model carries no effect.
ThreeSentences without_terms(const GapComparison& comparison) {
  return {fmt::format("Unit {}: model {} contains no accepted effect, so before and after are the same.",
                      comparison.unit, comparison.model),
          fmt::format("{}The figures below say how far it is from what was measured.",
                      fresh_runs(comparison) == 0 ? "No run is fresh: all were fitted. " : ""),
          fmt::format("Next: 'soak gap find --unit {}' looks for what it lacks.", comparison.unit)};
}

std::string verify_command(const GapComparison& comparison) {
  return fmt::format("'soak verify --unit {} --campaign NAME'", comparison.unit);
}

/// Of effects of which fresh runs can show nothing: what that is, and how the model is judged then.
ThreeSentences without_evidence(const GapComparison& comparison, std::string what) {
  std::vector<std::string> mounted;
  std::vector<std::string> in_readings;
  for (const ModelTerm& term : comparison.terms) (moves_blocks(term.name) ? mounted : in_readings).push_back(term.name);
  std::vector<std::string> why;
  if (!mounted.empty()) why.push_back(fmt::format("{} is another in each mounting", fmt::join(mounted, ", ")));
  if (!in_readings.empty()) {
    why.push_back(fmt::format("{} shows in single readings, not in the means that are compared here",
                              fmt::join(in_readings, ", ")));
  }
  return {
      std::move(what), fmt::format("A fresh run cannot tell whether that is right: {}.", fmt::join(why, "; ")),
      fmt::format("Next: judge model {} as a whole on fresh runs: {}.", comparison.model, verify_command(comparison))};
}

/// " Of aging_drift a fresh run shows only what changes within it."; empty where it shows all.
std::string shown_in_part(const GapComparison& comparison) {
  std::string text;
  for (const ModelTerm& term : comparison.terms) {
    const ShownPart shown = shown_by_fresh_runs(term.name);
    if (shown == ShownPart::all) continue;
    text += fmt::format(" Of {} a fresh run shows {}.", term.name,
                        shown == ShownPart::nothing ? "nothing" : "only what changes within it");
  }
  return text;
}

std::string next_words(const GapComparison& comparison, FreshOutcome outcome) {
  const std::vector<std::string> names =
      outcome == FreshOutcome::worse ? blamed(comparison) : std::vector<std::string>{};
  if (outcome == FreshOutcome::helped) {
    return fmt::format("Next: judge model {} on fresh runs and release it: {}, 'soak release --unit {}'.",
                       comparison.model, verify_command(comparison), comparison.unit);
  }
  if (outcome == FreshOutcome::not_shown) {
    return fmt::format(
        "Next: these runs do not show that it helps, nor that it harms: record one more run with a procedure whose "
        "purpose is verification, then 'soak gap show --unit {}' again.",
        comparison.unit);
  }
  if (names.empty()) {
    return fmt::format(
        "Next: a sensor has become worse on which no effect acts that a fresh run shows: look at its curve, "
        "'soak report --unit {}', before you deploy model {}.",
        comparison.unit, comparison.model);
  }
  return fmt::format(
      "Next: {} does not hold on fresh runs, so take it out: 'soak gap withdraw --unit {} --effect {} --reason TEXT'.",
      fmt::join(names, " or "), comparison.unit, names.front());
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
  const auto shows_nothing = [](const ModelTerm& term) { return shown_by_fresh_runs(term.name) == ShownPart::nothing; };
  const FreshOutcome outcome = outcome_of(comparison, sensors);
  if (outcome != FreshOutcome::worse && std::ranges::all_of(comparison.terms, shows_nothing)) {
    return without_evidence(comparison, what);
  }
  return {what, closed_words(comparison, sensors) + shown_in_part(comparison), next_words(comparison, outcome)};
}

}  // namespace soak::station
