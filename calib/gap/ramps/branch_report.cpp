// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/branch_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "base/statistics.h"
#include "calib/gap/ramps/detail/branch_search.h"

namespace soak::calib::gap::ramps {
namespace {

constexpr double kLeftOver = 0.25;  ///< share of the sensors with a gap from which names are withheld
constexpr double kProbability = 0.95;

Magnitude magnitude_on_ramps(const OnRamps& shown, const Candidate& candidate, const WholeFit& fit, Sensor sensor) {
  if (shown.size == OnRamps::Size::time_constant) return {candidate.shape_values.front(), "s"};
  const double value = shown.size == OnRamps::Size::largest ? fit.term.cwiseAbs().maxCoeff() : fit.parameters(0);
  return {value * printed_per_si(sensor), std::string(printed_unit(sensor)) + std::string(shown.per)};
}

/// What the folds say of one sensor and the winner.
struct Explained {
  Sensor sensor;
  const SensorResult* result;
  const Outcome* outcome;
};

/// Sensors that take the same shape, as one entry.
NamedEffect entry_of(const RampEffect& effect, const std::vector<Explained>& group, const BranchFits& fits) {
  const Candidate& candidate = effect.candidates()[group.front().outcome->candidate];
  NamedEffect entry;
  entry.effect = effect.effect;
  entry.candidate = {.shape = candidate.shape, .shape_values = candidate.shape_values, .shared = candidate.shared};
  entry.p_adjusted = 0.0;
  double before = 0.0;
  double after = 0.0;
  double clearest = 0.0;
  for (const auto& [sensor, result, outcome] : group) {
    entry.sensors.push_back(sensor);
    entry.p_adjusted = std::max(entry.p_adjusted, outcome->p_adjusted);
    entry.delta_bic += outcome->delta_bic;
    before += result->before / result->floor;
    after += outcome->after / result->floor;
    const std::size_t s = index_of(sensor);
    const WholeFit fit = fits[s]->fit_all(&candidate);
    entry.parameters[s] = fit.parameters;
    entry.covariance[s] = fit.covariance;
    entry.meaning[s] = effect.shown.meaning(candidate, sensor);
    if (result->before < clearest * outcome->after) continue;
    clearest = result->before / outcome->after;
    entry.magnitude = magnitude_on_ramps(effect.shown, candidate, fit, sensor);
  }
  entry.merit = entry.delta_bic;
  entry.heldout_gain = 1.0 - std::sqrt(after / before);
  return entry;
}

std::vector<NamedEffect> entries_of(const BranchResult& result, const std::vector<RampEffect>& effects,
                                    const BranchFits& fits) {
  const RampEffect& effect = effects[*result.winner];
  std::vector<std::vector<Explained>> groups(effect.candidates().size());
  for (const Sensor sensor : result.explained) {
    const SensorResult& own = *result.sensor[index_of(sensor)];
    const Outcome& outcome = own.outcomes[*result.winner];
    groups[outcome.candidate].push_back({sensor, &own, &outcome});
  }
  std::vector<NamedEffect> entries;
  for (const auto& group : groups) {
    if (group.empty()) continue;
    entries.push_back(entry_of(effect, group, fits));
    for (const std::size_t rival : result.rivals) entries.back().rivals.push_back({effects[rival].effect, {}});
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const NamedEffect& a, const NamedEffect& b) { return a.merit > b.merit; });
  return entries;
}

ResidualStructure residual_structure_of(const BranchResult& result, StructureKind kind, std::string axis,
                                        std::vector<Sensor> sensors) {
  ResidualStructure structure{.kind = kind, .axis = std::move(axis), .sensors = std::move(sensors)};
  structure.recorded.on_ramps = true;
  for (const Sensor sensor : structure.sensors) {
    structure.p_adjusted = std::min(structure.p_adjusted, result.sensor[index_of(sensor)]->p_gap);
  }
  return structure;
}

/// No effect predicts any sensor.
void decide_without_names(const BranchResult& result, bool halves, GapReport& report) {
  if (result.unexplained.empty()) {
    report.conclusion = Conclusion::none;
    report.reason =
        fmt::format("nothing beyond the scatter of the blocks and the detection limit{}",
                    halves ? "; two branches only: an effect that comes and goes with each cycle needs a third" : "");
    return;
  }
  std::vector<Sensor> alike;
  for (const Sensor sensor : result.unexplained) {
    if (result.sensor[index_of(sensor)]->repeats) alike.push_back(sensor);
  }
  if (alike.empty()) {
    report.conclusion = Conclusion::cannot_judge;
    report.reason = fmt::format(
        "the branches differ in {}, in a way that neither repeats nor follows from an effect of the library: record {}",
        list_of(result.unexplained), halves ? "a third branch" : "the cycle once more");
    return;
  }
  report.conclusion = Conclusion::unknown;
  report.reason = fmt::format(
      "heating and cooling differ alike each time in {}, and no effect of the library predicts it", list_of(alike));
  report.residual_structure =
      residual_structure_of(result, StructureKind::direction_of_sweep, "direction of the sweep", std::move(alike));
}

/// "", or " (thermal_hysteresis as well)".
std::string as_well(const std::vector<Rival>& rivals) {
  std::vector<std::string_view> names;
  for (const Rival& rival : rivals) names.push_back(rival.effect->name);
  return names.empty() ? "" : fmt::format(" ({} as well: this recording cannot tell which)", fmt::join(names, ", "));
}

void decide_on_ramps(const BranchResult& result, const std::vector<RampEffect>& effects, const BranchFits& fits,
                     bool halves, GapReport& report) {
  if (!result.winner) return decide_without_names(result, halves, report);
  const RampEffect& winner = effects[*result.winner];
  const bool drifts = winner.nuisance || std::any_of(result.rivals.begin(), result.rivals.end(),
                                                     [&](std::size_t m) { return effects[m].nuisance; });
  const auto rest = static_cast<double>(result.unexplained.size());
  const bool strange = rest > kLeftOver * (rest + static_cast<double>(result.explained.size()));
  std::vector<NamedEffect> entries = entries_of(result, effects, fits);
  report.conclusion = halves || drifts || strange ? Conclusion::unknown : Conclusion::named;
  report.reason = fmt::format("{}{} predicts {} in the data left out", winner.effect->name,
                              as_well(entries.front().rivals), list_of(result.explained));
  (report.conclusion == Conclusion::named ? report.effects : report.suspects) = std::move(entries);
  if (rest > 0.0) report.reason += fmt::format("; no effect predicts {}", list_of(result.unexplained));
  if (drifts) {
    report.reason += "; a drift in time does so as well: the same cycle once more would decide";
    report.residual_structure =
        residual_structure_of(result, StructureKind::drift_in_run, "time of the recording", result.explained);
  } else if (strange) {
    report.reason += ": too much remains unexplained to name it";
  }
  if (halves) report.reason += "; two branches give only one difference: a third branch would decide";
}

/// Ratio of means over the folds with its t interval.
void close(const SensorResult& result, const Outcome& outcome, const BranchFit& fit, SensorGap& gap) {
  gap.after_rms = std::sqrt(outcome.after);
  std::vector<double> open;
  std::vector<double> closed;
  for (std::size_t f = 0; f < outcome.errors.size(); ++f) {
    if (fit.weight()[f] <= 0.0) continue;
    const double before = std::sqrt(fit.base().error[f]);
    open.push_back(before - std::sqrt(fit.base().floor[f]));
    closed.push_back(before - std::sqrt(outcome.errors[f]));
  }
  const double fraction = (gap.before_rms - gap.after_rms) / (std::sqrt(result.before) - std::sqrt(result.floor));
  gap.closed_fraction = fraction;
  const auto count = static_cast<double>(open.size());
  double mean = 0.0;
  double off = 0.0;
  double squares = 0.0;
  for (std::size_t f = 0; f < open.size(); ++f) {
    mean += open[f] / count;
    off += (closed[f] - fraction * open[f]) / count;
    squares += std::pow(closed[f] - fraction * open[f], 2) / count;
  }
  if (count < 3.0 || mean <= 0.0) return;
  const double error = std::sqrt(std::max(0.0, squares - off * off) / (count - 1.0));
  const double half = base::student_t_two_sided(kProbability, count - 1.0) * error / mean;
  gap.closed_ci95 = {fraction - half, fraction + half};
}

void report_gaps(const BranchResult& result, const BranchFits& fits, GapReport& report) {
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    if (!result.sensor[s]) continue;
    const SensorResult& own = *result.sensor[s];
    const double before = std::sqrt(own.before);
    report.detection_limit[s] = std::sqrt(own.limit);
    report.gap[s] = SensorGap{.before_rms = before,
                              .after_rms = before,
                              .floor_rms = std::sqrt(own.floor),
                              .closed_fraction = {},
                              .closed_ci95 = {}};
    const bool named = report.conclusion == Conclusion::named &&
                       std::find(result.explained.begin(), result.explained.end(), sensor) != result.explained.end();
    if (named) close(own, own.outcomes[*result.winner], *fits[s], *report.gap[s]);
  }
}

/// Effects that one attitude without plateaus cannot show, each with why: those that need positions, plateaus or runs,
/// and those whose channel was not recorded.
std::vector<NotTestable> not_testable_by_branches(const std::vector<RampEffect>& tried) {
  constexpr const char* kPositions = "one attitude: needs readings in several positions";
  std::vector<NotTestable> list = {
      {"g_sensitivity", kPositions},
      {"earth_rate", kPositions},
      {"cross_axis", kPositions},
      {"scale_nonlinearity", kPositions},
      {"position_memory", kPositions},
      {"temperature_gradient", "only looked for in campaigns with plateaus: on a ramp it goes with the rate"},
      {"moisture", "only looked for in campaigns with plateaus: in one recording it goes with its time"},
      {"fixture_tilt", "one attitude: a mounting that leans is part of the accelerometers' bias"},
      {"narrow_bump", "the base follows a feature that all branches share"},
      {"aging_drift", "runs over weeks are needed; a drift within the recording is listed as a rival, never named"},
      {"noise_vs_temperature", "needs three runs with plateaus"},
      {"quantization", "only looked for in campaigns with plateaus"},
      {"saturation", "only looked for in campaigns with plateaus; sensors with clipped readings were left out"}};
  const auto missing = [&](std::string_view name) {
    return std::none_of(tried.begin(), tried.end(),
                        [&](const RampEffect& effect) { return effect.effect->name == name; });
  };
  if (missing("supply_sensitivity"))
    list.push_back({"supply_sensitivity", "supply_v was not recorded, or never moved"});
  if (missing("vibration_rectification")) {
    list.push_back({"vibration_rectification", "compressor was not recorded, or never moved"});
  }
  if (missing("warmup_transient")) list.push_back({"warmup_transient", "the time since power-on is not known"});
  return list;
}

}  // namespace

GapReport judge_branches(const LoggedCampaign& campaign, const RampRecording& recording, GapReport report) {
  const auto plan = plan_folds(recording);
  if (!plan) {
    return cannot_judge(std::move(report),
                        "one attitude without plateaus is judged by branches of at least 10 K: needs heating and "
                        "cooling over the same 20 K, better cooling, heating and cooling again");
  }
  report.judged_on = plan->halves ? JudgedOn::halves : JudgedOn::branches;
  const TemperatureHistory history(campaign, recording.observations);
  if (const auto& coarse = history.coarse()) {
    return cannot_judge(std::move(report),
                        *coarse + ": the curve cannot be told from what follows the temperature history");
  }
  if (!history.continuous()) {
    return cannot_judge(std::move(report),
                        "the temperature was not logged throughout: holes of more than five minutes");
  }
  BranchFits fits;
  for (const Sensor sensor : kSensors) fits[index_of(sensor)] = BranchFit::of(recording, *plan, sensor);
  if (std::none_of(fits.begin(), fits.end(), [](const auto& fit) { return fit.has_value(); })) {
    return cannot_judge(std::move(report),
                        "no sensor has readings that scatter in two branches at common temperatures");
  }
  const std::vector<RampEffect> tried = effects_on_ramps(recording, history, plan->halves);
  const BranchResult result = search_branches(fits, tried, plan->halves);
  decide_on_ramps(result, tried, fits, plan->halves, report);
  // No procedure repeats a recording without plateaus: the library's sentence stands for the simulated ranking.
  for (const NamedEffect& named : report.effects) {
    report.next.push_back({named.rivals.empty() ? std::string() : std::string(named.effect->experiment), {}});
  }
  report_gaps(result, fits, report);
  report.not_testable = not_testable_by_branches(tried);
  return report;
}

}  // namespace soak::calib::gap::ramps
