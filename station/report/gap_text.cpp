// SPDX-License-Identifier: Apache-2.0
#include "station/report/gap_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>

#include "station/io/output.h"
#include "station/report/gap_words.h"
#include "station/report/term_text.h"

namespace soak::station {
namespace {

using calib::gap::GapReport;
using calib::gap::NamedEffect;

std::string effect_text(const NamedEffect& effect, const std::string& next_experiment) {
  std::string text = fmt::format("  {}\n    {}\n    probability that noise alone looks like this: {:.2g}\n",
                                 size_text(effect.effect->name, effect.magnitude.value, effect.magnitude.unit,
                                           effect.candidate.shape, sensors_text(effect.sensors)),
                                 effect.effect->physics, effect.p_adjusted);
  std::vector<std::string> open;
  std::vector<std::string> out;
  for (const calib::gap::Rival& rival : effect.rivals) (has_chance(rival) ? open : out).push_back(rival_text(rival));
  if (!open.empty()) text += fmt::format("    nearly as good: {}\n", fmt::join(open, ", "));
  if (!out.empty()) text += fmt::format("    ruled out: {}\n", fmt::join(out, ", "));
  if (!open.empty() && !next_experiment.empty()) {
    text += fmt::format("    next experiment: {}\n", next_experiment);
  }
  return text;
}

std::string gap_table(const GapReport& report) {
  std::vector<std::vector<std::string>> table = {
      {"sensor", "unit", "before", "after", "noise floor", "closed", "95 %", "detectable"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& gap = report.gap[calib::index_of(sensor)];
    const auto& limit = report.detection_limit[calib::index_of(sensor)];
    if (!gap) continue;
    const double factor = calib::printed_per_si(sensor);
    table.push_back({std::string(calib::name_of(sensor)), std::string(calib::printed_unit(sensor)),
                     fmt::format("{:.3g}", gap->before_rms * factor), fmt::format("{:.3g}", gap->after_rms * factor),
                     fmt::format("{:.3g}", gap->floor_rms * factor),
                     gap->closed_fraction ? fmt::format("{:.0f} %", 100.0 * *gap->closed_fraction)
                     : report.judged_on == calib::gap::JudgedOn::runs ? "too small to tell"
                                                                      : "-",
                     gap->closed_ci95 ? fmt::format("{:.0f}..{:.0f} %", 100.0 * gap->closed_ci95->first,
                                                    100.0 * gap->closed_ci95->second)
                                      : "-",
                     limit ? fmt::format("{:.2g}", *limit * factor) : "-"});
  }
  return text_table(table);
}

std::string_view judged_on_text(calib::gap::JudgedOn judged_on) {
  return judged_on == calib::gap::JudgedOn::runs       ? "runs"
         : judged_on == calib::gap::JudgedOn::branches ? "branches"
                                                       : "half the difference between branches";
}

/// What the data gate rejected, a line for each run and sensor.
std::string rejected_text(const GapReport& report) {
  std::string text;
  for (const calib::gap::GateRejection& entry : report.rejections) {
    text += fmt::format("rejected by the data gate: run {}{}: {} of {} segments ({}): {}\n", entry.run,
                        entry.sensor ? fmt::format(", {}", calib::name_of(*entry.sensor)) : "", entry.segments,
                        entry.of, entry.code, entry.why);
  }
  return text;
}

/// What is left beside names, or instead of them, and where a bias steps.
std::string structure_text(const calib::gap::ResidualStructure& structure) {
  const calib::gap::StructureWords words = calib::gap::words_of(structure.kind, structure.recorded);
  std::string text = fmt::format(
      "what is left changes with {} in {} ({}; probability that noise alone looks like this: {:.2g})\n  usually: {}\n  "
      "look at: {}\n",
      structure.axis, sensors_text(structure.sensors), calib::gap::name_of(structure.kind), structure.p_adjusted,
      words.usual, words.look);
  if (structure.steps.empty()) return text;
  std::vector<std::vector<std::string>> table = {
      {"step in run", "sensor", "t_s", "after its first plateau block, min", "at °C", "size", "unit"}};
  for (const calib::gap::BiasStep& step : structure.steps) {
    table.push_back({step.run, std::string(calib::name_of(step.sensor)), fmt::format("{:.0f}", step.t_s),
                     fmt::format("{:.0f} to {:.0f}", step.before_s / 60.0, step.since_s / 60.0),
                     fmt::format("{:.1f}", step.temp_c),
                     fmt::format("{:.2g}", step.size * calib::printed_per_si(step.sensor)),
                     std::string(calib::printed_unit(step.sensor))});
  }
  return text + text_table(table);
}

std::vector<std::string> comparison_row(calib::Sensor sensor, const SensorComparison& figures, const std::string& runs,
                                        const std::string& closed) {
  const double factor = calib::printed_per_si(sensor);
  const auto text = [&](double value) { return fmt::format("{:.3g}", value * factor); };
  return {std::string(calib::name_of(sensor)),
          std::string(calib::printed_unit(sensor)),
          runs,
          text(figures.before_rms),
          text(figures.after_rms),
          figures.floor_rms ? text(*figures.floor_rms) : "-",
          text(figures.noise_rms),
          closed};
}

std::string closed_text(const SensorComparison& figures) {
  return figures.closed_fraction ? fmt::format("{:.0f} %", 100.0 * *figures.closed_fraction) : "too small to tell";
}

/// Length of the blocks that are compared, in words.
std::string_view block_words(const GapComparison& comparison) {
  return comparison.at_plateaus ? "one-minute" : "30-second";
}

}  // namespace

std::string slow_noise_table(const std::vector<calib::gap::SensorWander>& wanders) {
  if (wanders.empty()) return {};
  std::vector<std::vector<std::string>> table = {
      {"slow noise of", "unit", "within a run", "within minutes", "within hours", "bias instability B at rest"}};
  for (const calib::gap::SensorWander& wander : wanders) {
    const double factor = calib::printed_per_si(wander.sensor);
    const auto& rest = wander.at_rest;
    table.push_back({std::string(calib::name_of(wander.sensor)), std::string(calib::printed_unit(wander.sensor)),
                     fmt::format("{:.2g}", wander.within_run * factor),
                     fmt::format("{:.0f} %", 100.0 * wander.share_minutes),
                     fmt::format("{:.0f} %", 100.0 * wander.share_hours),
                     rest ? fmt::format("{:.2g} ({:.2g} to {:.2g}) at {:.0f} s", rest->value * factor,
                                        rest->low * factor, rest->high * factor, rest->tau_s)
                          : "-"});
  }
  return text_table(table);
}

std::string find_text(const GapReport& report, const std::vector<calib::ModelTerm>& carried) {
  const bool judged = report.conclusion != calib::gap::Conclusion::cannot_judge;
  std::string text = fmt::format("{}\n\nverdict: {}{}\n", fmt::join(sentences_of(report, carried), "\n"),
                                 calib::gap::name_of(report.conclusion), judged ? ": " + plain_reason(report) : "");
  for (std::size_t e = 0; e < report.effects.size(); ++e) {
    text += effect_text(report.effects[e], report.next.at(e).text);
  }
  if (!report.suspects.empty()) {
    text += "possible, but not certain enough to be named:\n";
    for (const NamedEffect& effect : report.suspects) text += effect_text(effect, "");
  }
  if (report.residual_structure) text += structure_text(*report.residual_structure);
  if (judged) {
    text += fmt::format("\ngap on {} that were not used for the fit (RMS of {} means):\n{}",
                        judged_on_text(report.judged_on),
                        report.judged_on == calib::gap::JudgedOn::runs ? "one-minute" : "30-second", gap_table(report));
  }
  if (!report.slow_noise.empty()) {
    text += fmt::format("\nslow noise (bias instability, rate random walk), counted as noise:\n{}",
                        slow_noise_table(report.slow_noise));
  }
  for (const calib::Warning& note : report.notes) text += fmt::format("note: {}\n", note.text);
  for (const auto& entry : report.not_testable) text += fmt::format("not testable: {}: {}\n", entry.name, entry.why);
  return text + rejected_text(report);
}

std::string terms_text(const std::vector<calib::ModelTerm>& terms, const std::vector<std::vector<std::string>>& sizes) {
  std::string text;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    for (const std::string& line : sizes.at(t)) {
      text += fmt::format("  {}{}\n", line, terms[t].lab_only ? " (lab only)" : " (in the calibration file)");
    }
  }
  return text;
}

std::string show_text(const GapComparison& comparison, const ThreeSentences& sentences,
                      const std::vector<std::vector<std::string>>& sizes) {
  std::string text =
      fmt::format("{}\n\nmeasurement minus simulation, with model {} and with model {}\n{}\n",
                  fmt::join(sentences, "\n"), comparison.before, comparison.model, terms_text(comparison.terms, sizes));
  std::vector<std::vector<std::string>> table = {
      {"sensor", "unit", "runs", "before", "after", "floor", "noise", "closed"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    if (comparison.fitted[s]) table.push_back(comparison_row(sensor, *comparison.fitted[s], "fitted", "-"));
    if (comparison.fresh[s])
      table.push_back(comparison_row(sensor, *comparison.fresh[s], "fresh", closed_text(*comparison.fresh[s])));
  }
  text += fmt::format(
      "{}RMS of {} blocks about each run's own mean. fresh: runs that neither model was fitted to; floor: what noise "
      "and\nrun-to-run scatter would leave with a perfect model (fitted runs lie below it, because the fit follows "
      "part of their noise)\n",
      text_table(table), block_words(comparison));
  for (const std::string& sentence : remarks(comparison)) text += sentence + "\n";
  const std::string slow = slow_noise_table(comparison.slow_noise);
  return slow.empty() ? text : fmt::format("{}\nslow noise, as the search before found it:\n{}", text, slow);
}

}  // namespace soak::station
