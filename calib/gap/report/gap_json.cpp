// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/gap_report.h"

#include <nlohmann/json.hpp>

namespace soak::calib::gap {
namespace {

nlohmann::json names_of(const std::vector<Sensor>& sensors) {
  nlohmann::json list = nlohmann::json::array();
  for (const Sensor sensor : sensors) list.push_back(name_of(sensor));
  return list;
}

nlohmann::json experiments_json(const NextExperiment& next) {
  nlohmann::json list = nlohmann::json::array();
  for (const Experiment& experiment : next.experiments) {
    list.push_back(
        {{"action", experiment.action},
         {"procedure", experiment.procedure.empty() ? nlohmann::json() : nlohmann::json(experiment.procedure)},
         {"hours", experiment.hours},
         {"sigma", experiment.sigma},
         {"needs", experiment.needs.empty() ? nlohmann::json() : nlohmann::json(experiment.needs)}});
  }
  return list;
}

nlohmann::json effect_json(const NamedEffect& effect, std::string_view status, const NextExperiment& next) {
  nlohmann::json rivals = nlohmann::json::array();
  nlohmann::json odds = nlohmann::json::object();
  for (const Rival& rival : effect.rivals) {
    rivals.push_back(rival.effect->name);
    if (rival.odds) odds[std::string(rival.effect->name)] = *rival.odds;
  }
  return {{"name", effect.effect->name},
          {"status", status},
          {"sensors", names_of(effect.sensors)},
          {"shape", effect.candidate.shape},
          {"magnitude", {{"value", effect.magnitude.value}, {"unit", effect.magnitude.unit}}},
          {"evidence",
           {{"delta_bic", effect.delta_bic}, {"p_adjusted", effect.p_adjusted}, {"heldout_gain", effect.heldout_gain}}},
          {"physics", effect.effect->physics},
          {"confusable_with", std::move(rivals)},
          {"odds", std::move(odds)},
          {"next_experiment", next.text.empty() ? nlohmann::json() : nlohmann::json(next.text)},
          {"experiments", experiments_json(next)}};
}

nlohmann::json effects_json(const GapReport& report) {
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t e = 0; e < report.effects.size(); ++e) {
    list.push_back(effect_json(report.effects[e], "named", report.next.at(e)));
  }
  return list;
}

/// What was named on the way to another verdict is not worth a run of its own.
nlohmann::json suspects_json(const GapReport& report) {
  nlohmann::json list = nlohmann::json::array();
  for (const NamedEffect& suspect : report.suspects) list.push_back(effect_json(suspect, "suspected", {}));
  return list;
}

nlohmann::json gap_of(const SensorGap& gap, double factor) {
  nlohmann::json interval;
  if (gap.closed_ci95) interval = {gap.closed_ci95->first, gap.closed_ci95->second};
  return {{"before_rms", gap.before_rms * factor},
          {"after_rms", gap.after_rms * factor},
          {"floor_rms", gap.floor_rms * factor},
          {"closed_fraction", gap.closed_fraction ? nlohmann::json(*gap.closed_fraction) : nlohmann::json()},
          {"closed_ci95", std::move(interval)}};
}

nlohmann::json gaps_json(const SensorGaps& gaps) {
  nlohmann::json object = nlohmann::json::object();
  for (const Sensor sensor : kSensors) {
    const auto& gap = gaps[index_of(sensor)];
    if (gap) object[std::string(name_of(sensor))] = gap_of(*gap, printed_per_si(sensor));
  }
  return object;
}

nlohmann::json rejections_json(const std::vector<GateRejection>& rejections) {
  nlohmann::json list = nlohmann::json::array();
  for (const GateRejection& entry : rejections) {
    list.push_back({{"run", entry.run},
                    {"sensor", entry.sensor ? nlohmann::json(name_of(*entry.sensor)) : nlohmann::json()},
                    {"segments", entry.segments},
                    {"of", entry.of},
                    {"code", entry.code},
                    {"why", entry.why}});
  }
  return list;
}

nlohmann::json notes_json(const std::vector<Warning>& notes) {
  nlohmann::json list = nlohmann::json::array();
  for (const Warning& note : notes) list.push_back({{"code", note.code}, {"text", note.text}});
  return list;
}

nlohmann::json structure_json(const ResidualStructure& structure) {
  nlohmann::json steps = nlohmann::json::array();
  for (const BiasStep& step : structure.steps) {
    steps.push_back({{"run", step.run},
                     {"sensor", name_of(step.sensor)},
                     {"t_s", step.t_s},
                     {"since_start_s", step.since_s},
                     {"last_before_s", step.before_s},
                     {"temp_c", step.temp_c},
                     {"size", step.size * printed_per_si(step.sensor)},
                     {"unit", printed_unit(step.sensor)}});
  }
  const StructureWords words = words_of(structure.kind, structure.recorded);
  return {{"axis", structure.axis},
          {"kind", name_of(structure.kind)},
          {"usual", words.usual},
          {"look", words.look},
          {"closer_plateaus_k",
           structure.closer_plateaus_k ? nlohmann::json(*structure.closer_plateaus_k) : nlohmann::json()},
          {"p_adjusted", structure.p_adjusted},
          {"sensors", names_of(structure.sensors)},
          {"runs", structure.recorded.on_ramps ? nlohmann::json() : nlohmann::json(structure.recorded.runs)},
          {"steps", std::move(steps)}};
}

}  // namespace

nlohmann::json gap_json(const GapReport& report) {
  nlohmann::json not_testable = nlohmann::json::array();
  for (const NotTestable& entry : report.not_testable)
    not_testable.push_back({{"name", entry.name}, {"why", entry.why}});
  nlohmann::json limits = nlohmann::json::object();
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    const double factor = printed_per_si(sensor);
    if (report.detection_limit[s]) limits[std::string(name_of(sensor))] = *report.detection_limit[s] * factor;
  }
  nlohmann::json structure;
  if (report.residual_structure) structure = structure_json(*report.residual_structure);
  nlohmann::json locked;
  if (report.locked) locked = {{"run", report.locked->label}, {"gap", gaps_json(report.locked->gap)}};
  return {{"unit", report.unit},
          {"model", report.model},
          {"verdict", name_of(report.conclusion)},
          {"reason", report.reason},
          {"notes", notes_json(report.notes)},
          {"held_out", name_of(report.judged_on)},
          {"effects", effects_json(report)},
          {"suspects", suspects_json(report)},
          {"residual_structure", std::move(structure)},
          {"slow_noise", slow_noise_json(report.slow_noise)},
          {"not_testable", std::move(not_testable)},
          {"rejected_by_gate", rejections_json(report.rejections)},
          {"detection_limit", std::move(limits)},
          {"gap", gaps_json(report.gap)},
          {"map", report.map ? map_json(*report.map) : nlohmann::json()},
          {"locked_run", std::move(locked)}};
}

}  // namespace soak::calib::gap
