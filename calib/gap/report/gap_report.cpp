// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/gap_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>

#include "base/statistics.h"
#include "calib/gap/base/run_agreement.h"
#include "calib/gap/effects/columns.h"
#include "calib/gap/noise/wander_estimate.h"
#include "calib/gap/ramps/branch_report.h"
#include "calib/gap/search/detail/slow_noise.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr int kLeastRuns = 2;
constexpr std::size_t kMostOpenRuns = 8;  ///< of more, one is locked away before the search
/// Sets of sensors among which a term may be named: all, gyros, accelerometers, each alone.
constexpr double kSets = 9.0;

/// Variance of a wander about its mean over a run, in the mean of the runs.
double wander_variance(const Observations& observations, const NoiseComponents& noise) {
  double sum = 0.0;
  for (int run = 0; run < observations.run_count(); ++run) sum += variance_about_mean(observations, noise.wander, run);
  return sum / observations.run_count();
}

/// F of one and the given degrees of freedom whose upper tail is `p`.
double f_quantile(double p, double dof) {
  double low = 0.0;
  double high = 1.0;
  while (base::f_upper_tail(high, 1.0, dof) > p) high *= 2.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (base::f_upper_tail(middle, 1.0, dof) > p ? low : high) = middle;
  }
  return high;
}

std::optional<double> detection_limit(const CampaignModel& model, std::size_t s, const SearchResult& found) {
  const Observations& observations = model.regressor_inputs().observations;
  if (!model.residuals().sensor[s] || found.candidates == 0) return std::nullopt;
  double visits = 0.0;
  double placements = 0.0;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const auto& row = observations.rows[i];
    if (i > 0 && row.placement == observations.rows[i - 1].placement) continue;
    placements += 1.0;
    if (i == 0 || row.visit != observations.rows[i - 1].visit || row.run != observations.rows[i - 1].run) visits += 1.0;
  }
  const NoiseComponents& noise = model.residuals().noise[s];
  const double blocks = static_cast<double>(observations.rows.size()) / placements;
  double of_visit = noise.visit * noise.visit +
                    (noise.placement * noise.placement + noise.block * noise.block / blocks) / (placements / visits);
  of_visit += wander_variance(observations, noise);
  const double p = kGate / (static_cast<double>(found.candidates) * kSets);
  const double f = f_quantile(p, scatter_dof(noise) + observations.run_count() - 1);
  return std::sqrt(f * std::max(1.0, found.typical_heterogeneity) * of_visit / visits);
}

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

/// What would let the curve between the plateaus be known.
std::string_view closer_plateaus(double widest_c) {
  if (widest_c > kCoarse_c) return ": plateaus 10 K apart would tell";
  return widest_c > kMedium_c ? ": plateaus 5 K apart would tell" : "";
}

std::string unknown_reason(const SearchResult& found, const RegressorInputs& in) {
  const ResidualStructure& structure = *found.residual_structure;
  const std::string absorbed = in_a_sentence(names_of_history(found.absorbed));
  const double widest_c = widest_step_c(in.observations.level_c);
  if (structure.of_history && !absorbed.empty()) {
    return fmt::format(
        "readings change with {}; {} would look like it, and cannot be told from the thermal curve here{}",
        structure.axis, absorbed, closer_plateaus(widest_c));
  }
  if (structure.of_history && widest_c > kCoarse_c) {
    return fmt::format(
        "readings change with {}; {} would look like it where the curve between the plateaus is not known{}",
        structure.axis, in_a_sentence(testable_of_history(in)), closer_plateaus(widest_c));
  }
  if (structure.between_effects) return fmt::format("readings change with {}", structure.axis);
  return fmt::format("readings change with {}, in a way that no effect of the library explains", structure.axis);
}

/// `outside`: effects that the means do not show.
void decide(SearchResult found, std::vector<NamedEffect> outside, const RegressorInputs& in, GapReport& report) {
  report.residual_structure = found.residual_structure;
  if (report.residual_structure && report.residual_structure->forbids_names) {
    report.conclusion = Conclusion::unknown;
    report.reason = unknown_reason(found, in);
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

void add_note(GapReport& report, std::string code, std::string text) {
  report.reason += "; " + text;
  report.notes.push_back({std::move(code), std::move(text)});
}

/// Names the sensors of the campaign that never scatter, which the search has to pass over.
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

/// Noise of a campaign in which the bias wanders: told by what the first search has left. Nothing where none of the
/// sensors that look so has wander, or where there are too few runs to tell one from what they share.
std::optional<KnownNoise> wandering_noise(const CampaignModel& model, const std::vector<NamedEffect>& effects,
                                          const std::vector<Sensor>& sensors) {
  constexpr int kLeastRunsOfWander = 4;
  const RegressorInputs in = model.regressor_inputs();
  if (sensors.empty() || in.observations.run_count() < kLeastRunsOfWander) return std::nullopt;
  const Eigen::MatrixXd of_day = time_of_day(in);
  KnownNoise noise = model.residuals().noise;
  std::optional<WanderEstimate> estimate;
  for (const Sensor sensor : kSensors) {
    if (!model.residuals().sensor[index_of(sensor)]) continue;
    const Eigen::VectorXd left = unexplained(model, effects, sensor);
    if (!estimate || !estimate->is_for(left)) estimate.emplace(in.observations, left, of_day);
    if (auto found = estimate->of(left, noise[index_of(sensor)])) noise[index_of(sensor)] = *std::move(found);
  }
  const auto wanders = [&](Sensor sensor) { return !noise[index_of(sensor)].wander.empty(); };
  if (std::none_of(sensors.begin(), sensors.end(), wanders)) return std::nullopt;
  return noise;
}

/// Says how far the bias of each sensor wanders, about its mean over a run.
void note_wander(const Observations& observations, const KnownNoise& noise, GapReport& report) {
  std::vector<std::string> sizes;
  for (const Sensor sensor : kSensors) {
    if (noise[index_of(sensor)].wander.empty()) continue;
    const double variance = wander_variance(observations, noise[index_of(sensor)]);
    sizes.push_back(fmt::format("{} {:.2g} {}", name_of(sensor), std::sqrt(variance) * printed_per_si(sensor),
                                printed_unit(sensor)));
  }
  add_note(report, "wandering_bias",
           fmt::format("the bias wanders while the unit runs, in another way in each run, as bias instability and rate "
                       "random walk do; that is counted as noise: {} (standard deviation within a run)",
                       fmt::join(sizes, ", ")));
}

/// Whether each position always comes after the same one: what it remembers of that is then a constant of its own.
bool one_order(const Observations& observations) {
  std::map<int, int> before;
  for (const Observation& row : observations.rows) {
    if (row.position < 0 || row.previous < 0) continue;
    if (before.try_emplace(row.position, row.previous).first->second != row.previous) return false;
  }
  return before.size() > 1;
}

/// Says what the order of the positions leaves open about the effects named.
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

/// Says what a thermometer in steps kept from being looked for, or what stands in for it.
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
    note_wander(observations, *noise, report);
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
