// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/gap_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "calib/gap/base/run_agreement.h"
#include "calib/gap/ramps/branch_report.h"
#include "calib/gap/report/detection_limit.h"
#include "calib/gap/report/report_notes.h"

namespace soak::calib::gap {
namespace {

constexpr int kLeastRuns = 2;
constexpr std::size_t kMostOpenRuns = 8;  ///< of more, one is locked away before the search

std::vector<std::string_view> names_of_history(const std::vector<const Effect*>& effects) {
  std::vector<std::string_view> names;
  for (const Effect* effect : effects) {
    if (effect->follows_history) names.push_back(effect->name);
  }
  return names;
}

/// What follows the temperature's history and can be looked for in this campaign.
std::vector<std::string_view> testable_of_history(const RegressorInputs& in) {
  std::vector<const Effect*> effects;
  for (const Effect& effect : library()) {
    if (!effect.missing(in)) effects.push_back(&effect);
  }
  return names_of_history(effects);
}

/// "a, b or c".
std::string in_a_sentence(std::vector<std::string_view> names) {
  if (names.size() < 2) return names.empty() ? "" : std::string(names.front());
  const std::string_view last = names.back();
  names.pop_back();
  return fmt::format("{} or {}", fmt::join(names, ", "), last);
}

constexpr double kCoarse_c = 12.0;
constexpr double kMedium_c = 6.0;

double widest_step_c(const std::vector<double>& level_c) {
  double widest_c = 0.0;
  for (std::size_t k = 1; k < level_c.size(); ++k) widest_c = std::max(widest_c, level_c[k] - level_c[k - 1]);
  return widest_c;
}

/// How far apart plateaus would let the curve between them be known; nothing where they are close already.
std::optional<double> closer_plateaus_k(double widest_c) {
  if (widest_c > kCoarse_c) return 10.0;
  if (widest_c > kMedium_c) return 5.0;
  return std::nullopt;
}

/// Says why nothing is named, and which plateaus would tell.
std::string unknown_reason(const SearchResult& found, const RegressorInputs& in, ResidualStructure& structure) {
  const std::string absorbed = in_a_sentence(names_of_history(found.absorbed));
  const double widest_c = widest_step_c(in.observations.level_c);
  const bool told_by_plateaus = structure.of_history && (!absorbed.empty() || widest_c > kCoarse_c);
  if (told_by_plateaus) structure.closer_plateaus_k = closer_plateaus_k(widest_c);
  const std::string closer = structure.closer_plateaus_k
                                 ? fmt::format(": plateaus {:g} K apart would tell", *structure.closer_plateaus_k)
                                 : std::string();
  if (structure.of_history && !absorbed.empty()) {
    return fmt::format(
        "readings change with {}; {} would look like it, and cannot be told from the thermal curve here{}",
        structure.axis, absorbed, closer);
  }
  if (structure.of_history && widest_c > kCoarse_c) {
    return fmt::format(
        "readings change with {}; {} would look like it where the curve between the plateaus is not known{}",
        structure.axis, in_a_sentence(testable_of_history(in)), closer);
  }
  if (structure.kind == StructureKind::between_effects) return fmt::format("readings change with {}", structure.axis);
  return fmt::format("readings change with {}, in a way that no effect of the library explains", structure.axis);
}

/// `outside`: effects that the means do not show.
void decide(SearchResult found, std::vector<NamedEffect> outside, const RegressorInputs& in, GapReport& report) {
  report.residual_structure = found.residual_structure;
  if (report.residual_structure && report.residual_structure->forbids_names) {
    report.conclusion = Conclusion::unknown;
    report.reason = unknown_reason(found, in, *report.residual_structure);
    report.suspects = std::move(found.effects);
    return;
  }
  std::stable_sort(found.effects.begin(), found.effects.end(),
                   [](const auto& a, const auto& b) { return a.merit > b.merit; });
  report.effects = std::move(found.effects);
  std::move(outside.begin(), outside.end(), std::back_inserter(report.effects));
  std::vector<std::string_view> names;
  for (const NamedEffect& named : report.effects) names.push_back(named.effect->name);
  report.conclusion = names.empty() ? Conclusion::none : Conclusion::named;
  report.reason = names.empty() ? "nothing beyond the scatter between runs and the detection limit"
                                : fmt::format("explained by {}", fmt::join(names, ", "));
}

/// Whether runs repeat each other enough to say how they scatter.
bool replicated(const CampaignModel& model) {
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (model.residuals().sensor[s] && !model.residuals().noise[s].replicated) return false;
  }
  return true;
}

/// Clipped readings say nothing of what the unit would have read: their sensors stay out of the search.
std::vector<Sensor> clipped_sensors(const LoggedCampaign& campaign) {
  std::vector<Sensor> sensors;
  for (const Sensor sensor : kSensors) {
    if (campaign.samples[index_of(sensor)].at_rails > 0) sensors.push_back(sensor);
  }
  return sensors;
}

void drop_clipped_sensors(const LoggedCampaign& campaign, Observations& observations) {
  for (const Sensor sensor : clipped_sensors(campaign)) {
    for (Observation& row : observations.rows) row.sensor[index_of(sensor)].count = 0;
  }
}

/// Index of the last run by time, by order where a run's time is not known.
std::size_t last_run(const std::vector<LoggedRun>& runs) {
  const auto timed = [](const LoggedRun& run) { return run.start_utc_s.has_value(); };
  if (!std::all_of(runs.begin(), runs.end(), timed)) return runs.size() - 1;
  const auto last = std::max_element(
      runs.begin(), runs.end(), [](const LoggedRun& a, const LoggedRun& b) { return *a.start_utc_s < *b.start_utc_s; });
  return static_cast<std::size_t>(last - runs.begin());
}

/// Adds to `report` what its effects do for run `number` of the campaign, which they have not seen; nothing where it
/// has no readings. A run that cannot be compared with the others leaves no conclusion.
void judge_locked_run(const LoggedCampaign& campaign, std::size_t number, GapReport& report) {
  Observations observations = observe(campaign);
  const auto found = std::find(observations.logged.begin(), observations.logged.end(), number);
  if (found == observations.logged.end()) return;
  drop_clipped_sensors(campaign, observations);
  const TemperatureHistory history(campaign, observations);
  if (auto differ = disagreement(CampaignModel(observations, history))) {
    GapReport none;
    none.unit = report.unit;
    none.model = report.model;
    report = cannot_judge(std::move(none), *std::move(differ));
    return;
  }
  const auto run = static_cast<int>(found - observations.logged.begin());
  report.locked = {observations.runs[static_cast<std::size_t>(run)],
                   gap_of_unseen_run(observations, history, report.effects, run, report.noise)};
}

/// Without plateaus: by branches of the temperature, where there are any.
GapReport find_without_plateaus(const LoggedCampaign& campaign, GapReport report) {
  auto recording = ramps::ramp_recording(campaign);
  if (!recording) {
    return cannot_judge(
        std::move(report),
        "no run has a plateau with readings of one-minute blocks; record a soak procedure, or ramps in one attitude");
  }
  if (auto same = same_readings(recording->observations)) return cannot_judge(std::move(report), *std::move(same));
  drop_clipped_sensors(campaign, recording->observations);
  return ramps::judge_branches(campaign, *recording, std::move(report));
}

/// Searches the library, looks outside the means, and decides. `report` is as it was before any search.
void search_all(const LoggedCampaign& campaign, CampaignModel& model, GapReport& report) {
  for (const Effect& effect : library()) {
    if (auto why = effect.missing(model.regressor_inputs())) {
      report.not_testable.push_back({std::string(effect.name), *std::move(why)});
    }
  }
  // First: what moves on from run to run does so within a run, where it would pass for a slow warm-up.
  OutsideTheMean outside = look_for_aging(campaign, model);
  for (const NamedEffect& effect : outside.effects) model.add_term(effect.candidate, effect.sensors, {});
  SearchResult found = search(model);
  for (const Effect* effect : found.absorbed) {
    report.not_testable.push_back({std::string(effect->name),
                                   "no sensor that it acts on has readings that can be judged, or the thermal model "
                                   "absorbs it in this campaign"});
  }
  for (std::size_t s = 0; s < kSensorCount; ++s) report.detection_limit[s] = detection_limit(model, s, found);
  outside.add(look_outside_the_mean(campaign, model));
  outside.add(look_for_bump(model));
  std::move(outside.not_testable.begin(), outside.not_testable.end(), std::back_inserter(report.not_testable));
  decide(std::move(found), std::move(outside.effects), model.regressor_inputs(), report);
}

/// Searches, and where it is time that readings follow, in each run otherwise, once more with noise that wanders.
/// `plain` then has that noise, too.
void search_noise_and_effects(const LoggedCampaign& campaign, const Observations& observations,
                              const TemperatureHistory& history, std::optional<CampaignModel>& plain,
                              GapReport& report) {
  const GapReport before = report;
  std::optional<CampaignModel> model = plain;
  search_all(campaign, *model, report);
  const std::vector<Sensor> wander =
      report.residual_structure ? report.residual_structure->may_wander : std::vector<Sensor>();
  if (auto noise = wandering_noise(*model, report.suspects, wander)) {
    plain.emplace(observations, history, std::nullopt, noise);
    model.emplace(*plain);
    report = before;
    search_all(campaign, *model, report);
    report.slow_noise = slow_noise_in(observations, *noise);
    note_wander(report);
    report.noise = std::move(noise);
  }
  note_sensors_without_scatter(observations, *model, report);
}

GapReport find_in(const LoggedCampaign& campaign, std::int32_t model_version) {
  GapReport report;
  report.unit = campaign.unit;
  report.model = model_version;
  Observations observations = observe(campaign);
  if (observations.rows.empty()) return find_without_plateaus(campaign, std::move(report));
  if (observations.run_count() < kLeastRuns) {
    return cannot_judge(std::move(report),
                        "one run only: a repeatable effect cannot be told from the scatter between runs; record a "
                        "second run of the same procedure");
  }
  if (auto same = same_readings(observations)) return cannot_judge(std::move(report), *std::move(same));
  drop_clipped_sensors(campaign, observations);
  const TemperatureHistory history(campaign, observations);
  std::optional<CampaignModel> plain(std::in_place, observations, history);
  if (!replicated(*plain)) {
    return cannot_judge(std::move(report),
                        "the runs do not repeat each other's plateaus, so their scatter is not known; record two runs "
                        "of one procedure");
  }
  if (auto differ = disagreement(*plain)) return cannot_judge(std::move(report), *std::move(differ));
  search_noise_and_effects(campaign, observations, history, plain, report);
  note_position_order(observations, report);
  note_thermometer(campaign, history, report);
  for (std::size_t e = 0; e < report.effects.size(); ++e) {
    report.next.push_back(next_experiment(campaign, *plain, report.effects, e));
  }
  report.gap = cross_validated_gap(observations, history, report.effects, report.noise);
  report.map = remainder_map(*plain, report.effects);
  return report;
}

/// Of more runs than may be open the last is locked away before the search, and judged alone.
GapReport find_in_open_runs(const LoggedCampaign& campaign, std::int32_t model_version) {
  if (campaign.runs.size() <= kMostOpenRuns) return find_in(campaign, model_version);
  const std::size_t number = last_run(campaign.runs);
  LoggedCampaign open = campaign;
  open.runs.erase(open.runs.begin() + static_cast<std::ptrdiff_t>(number));
  GapReport report = find_in(open, model_version);
  if (report.conclusion != Conclusion::cannot_judge) judge_locked_run(campaign, number, report);
  return report;
}

/// Nothing found in what the data gate accepts does not mean that nothing is there.
void note_rejections(const LoggedCampaign& campaign, GapReport& report) {
  report.rejections = rejected_by_gate(campaign);
  if (report.rejections.empty()) return;
  const std::string words = in_words(report.rejections);
  if (report.conclusion == Conclusion::none && mostly_rejected_run(report.rejections)) {
    report.reason = fmt::format(
        "the data gate rejected most of a run: {}; import it correctly or void it, then search again. In the rest: {}",
        words, report.reason);
    report.conclusion = Conclusion::cannot_judge;
    return;
  }
  report.reason += "; the data gate rejected " + words;
}

}  // namespace

GapReport cannot_judge(GapReport report, std::string reason) {
  report.conclusion = Conclusion::cannot_judge;
  report.reason = std::move(reason);
  return report;
}

GapReport find_gap(const LoggedCampaign& campaign, std::int32_t model_version) {
  GapReport report = find_in_open_runs(campaign, model_version);
  const std::vector<Sensor> clipped = clipped_sensors(campaign);
  if (report.conclusion != Conclusion::cannot_judge && !clipped.empty()) {
    add_note(report, "clipped", "not judged, as their readings stop at the end of their range: " + list_of(clipped));
  }
  note_rejections(campaign, report);
  return report;
}

}  // namespace soak::calib::gap
