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
#include "calib/gap/ramps/detail/not_testable.h"

namespace soak::calib::gap::reduced {
namespace {

constexpr double kCoarseStep_c = 0.1;
constexpr double kLeftOver = 0.25;  ///< share of the sensors with a gap from which names are withheld
constexpr double kProbability = 0.95;

std::string list_of(const std::vector<Sensor>& sensors) {
  std::vector<std::string_view> names;
  for (const Sensor sensor : sensors) names.push_back(name_of(sensor));
  return fmt::format("{}", fmt::join(names, ", "));
}

Magnitude magnitude_of(const Mechanism& mechanism, const Shape& shape, const WholeFit& fit, Sensor sensor) {
  if (mechanism.size == Size::time_constant) return {shape.values.front(), "s"};
  const double value = mechanism.size == Size::largest ? fit.term.cwiseAbs().maxCoeff() : fit.parameters(0);
  return {value * printed_per_si(sensor), std::string(printed_unit(sensor)) + mechanism.per};
}

/// What the folds say of one sensor and the winner.
struct Explained {
  Sensor sensor;
  const SensorFinding* finding;
  const Outcome* outcome;
};

/// Sensors that take the same shape, as one entry.
NamedEffect entry_of(const Mechanism& mechanism, const std::vector<Explained>& group, const Judges& judges) {
  const Shape& shape = mechanism.shapes[group.front().outcome->shape];
  NamedEffect entry;
  entry.effect = mechanism.effect;
  entry.candidate.shape = shape.text;
  entry.candidate.shape_values = shape.values;
  entry.candidate.shared = mechanism.shared;
  entry.p_adjusted = 0.0;
  double before = 0.0;
  double after = 0.0;
  double clearest = 0.0;
  for (const auto& [sensor, finding, outcome] : group) {
    entry.sensors.push_back(sensor);
    entry.p_adjusted = std::max(entry.p_adjusted, outcome->p_adjusted);
    entry.delta_bic += outcome->delta_bic;
    before += finding->before / finding->floor;
    after += outcome->after / finding->floor;
    if (finding->before < clearest * outcome->after) continue;
    clearest = finding->before / outcome->after;
    entry.magnitude = magnitude_of(mechanism, shape, judges[index_of(sensor)]->whole(&shape), sensor);
  }
  entry.merit = entry.delta_bic;
  entry.heldout_gain = 1.0 - std::sqrt(after / before);
  return entry;
}

std::vector<NamedEffect> entries_of(const BranchFinding& finding, const std::vector<Mechanism>& mechanisms,
                                    const Judges& judges) {
  const Mechanism& mechanism = mechanisms[*finding.winner];
  std::vector<std::vector<Explained>> groups(mechanism.shapes.size());
  for (const Sensor sensor : finding.explained) {
    const SensorFinding& own = *finding.sensor[index_of(sensor)];
    const Outcome& outcome = own.outcomes[*finding.winner];
    groups[outcome.shape].push_back({sensor, &own, &outcome});
  }
  std::vector<NamedEffect> entries;
  for (const auto& group : groups) {
    if (group.empty()) continue;
    entries.push_back(entry_of(mechanism, group, judges));
    for (const std::size_t rival : finding.rivals) entries.back().rivals.push_back(mechanisms[rival].effect);
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const NamedEffect& a, const NamedEffect& b) { return a.merit > b.merit; });
  return entries;
}

Leftover leftover_of(const BranchFinding& finding, std::string axis, std::vector<Sensor> sensors) {
  Leftover leftover{.axis = std::move(axis), .sensors = std::move(sensors)};
  for (const Sensor sensor : leftover.sensors) {
    leftover.p_adjusted = std::min(leftover.p_adjusted, finding.sensor[index_of(sensor)]->p_gap);
  }
  return leftover;
}

/// No mechanism predicts any sensor.
void decide_without_names(const BranchFinding& finding, bool halves, GapReport& report) {
  if (finding.unexplained.empty()) {
    report.verdict = Verdict::none;
    report.reason = fmt::format("nothing beyond the scatter of the blocks and the detection limit{}",
                                halves ? "; two branches only: what comes and goes with a cycle needs a third" : "");
    return;
  }
  std::vector<Sensor> alike;
  for (const Sensor sensor : finding.unexplained) {
    if (finding.sensor[index_of(sensor)]->repeats) alike.push_back(sensor);
  }
  if (alike.empty()) {
    report.verdict = Verdict::cannot_judge;
    report.reason = fmt::format(
        "the branches differ in {}, in a way that neither repeats nor follows from an effect of the library: record {}",
        list_of(finding.unexplained), halves ? "a third branch" : "the cycle once more");
    return;
  }
  report.verdict = Verdict::unknown;
  report.reason = fmt::format(
      "heating and cooling differ alike each time in {}, and no effect of the library predicts it", list_of(alike));
  report.leftover = leftover_of(finding, "direction of the sweep", std::move(alike));
}

/// "", or " (thermal_hysteresis as well)".
std::string as_well(const std::vector<const Effect*>& rivals) {
  std::vector<std::string_view> names;
  for (const Effect* rival : rivals) names.push_back(rival->name);
  return names.empty() ? "" : fmt::format(" ({} as well: this recording cannot tell which)", fmt::join(names, ", "));
}

void decide(const BranchFinding& finding, const std::vector<Mechanism>& mechanisms, const Judges& judges, bool halves,
            GapReport& report) {
  if (!finding.winner) return decide_without_names(finding, halves, report);
  const Mechanism& winner = mechanisms[*finding.winner];
  const bool drifts = winner.nuisance || std::any_of(finding.rivals.begin(), finding.rivals.end(),
                                                     [&](std::size_t m) { return mechanisms[m].nuisance; });
  const auto rest = static_cast<double>(finding.unexplained.size());
  const bool strange = rest > kLeftOver * (rest + static_cast<double>(finding.explained.size()));
  std::vector<NamedEffect> entries = entries_of(finding, mechanisms, judges);
  report.verdict = halves || drifts || strange ? Verdict::unknown : Verdict::named;
  report.reason = fmt::format("{}{} predicts {} on what was left out", winner.effect->name,
                              as_well(entries.front().rivals), list_of(finding.explained));
  (report.verdict == Verdict::named ? report.effects : report.suspects) = std::move(entries);
  if (rest > 0.0) report.reason += fmt::format("; nothing does in {}", list_of(finding.unexplained));
  if (drifts) {
    report.reason += "; a drift in time does as well, and the same cycle once more would tell";
    report.leftover = leftover_of(finding, "time of the recording", finding.explained);
  } else if (strange) {
    report.reason += ": too much is left to give it a name";
  }
  if (halves) report.reason += "; two branches have one difference only: a third would decide";
}

/// Ratio of means over the folds with its t interval.
void close(const SensorFinding& finding, const Outcome& outcome, const BranchJudge& judge, SensorGap& gap) {
  gap.after_rms = std::sqrt(outcome.after);
  std::vector<double> open;
  std::vector<double> closed;
  for (std::size_t f = 0; f < outcome.errors.size(); ++f) {
    if (judge.weight()[f] <= 0.0) continue;
    const double before = std::sqrt(judge.base().error[f]);
    open.push_back(before - std::sqrt(judge.base().floor[f]));
    closed.push_back(before - std::sqrt(outcome.errors[f]));
  }
  const double fraction = (gap.before_rms - gap.after_rms) / (std::sqrt(finding.before) - std::sqrt(finding.floor));
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

void report_gaps(const BranchFinding& finding, const Judges& judges, GapReport& report) {
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    if (!finding.sensor[s]) continue;
    const SensorFinding& own = *finding.sensor[s];
    const double before = std::sqrt(own.before);
    report.detection_limit[s] = std::sqrt(own.limit);
    report.gap[s] = SensorGap{.before_rms = before,
                              .after_rms = before,
                              .floor_rms = std::sqrt(own.floor),
                              .closed_fraction = {},
                              .closed_ci95 = {}};
    const bool named = report.verdict == Verdict::named &&
                       std::find(finding.explained.begin(), finding.explained.end(), sensor) != finding.explained.end();
    if (named) close(own, own.outcomes[*finding.winner], *judges[s], *report.gap[s]);
  }
}

GapReport cannot_judge(GapReport report, std::string reason) {
  report.verdict = Verdict::cannot_judge;
  report.reason = std::move(reason);
  return report;
}

}  // namespace

GapReport judge_branches(const LoggedCampaign& campaign, const RampRecording& recording, GapReport report) {
  const auto plan = plan_folds(recording);
  if (!plan) {
    return cannot_judge(std::move(report),
                        "one attitude without plateaus is judged by branches of at least 10 K: needs heating and "
                        "cooling over the same 20 K, better cooling, heating and cooling again");
  }
  report.held_out = plan->halves ? HeldOut::halves : HeldOut::branches;
  if (const auto& step_c = campaign.thermometer.step; step_c && *step_c >= kCoarseStep_c) {
    return cannot_judge(std::move(report),
                        fmt::format("the thermometer moves in steps of {:.2g} K: the curve cannot be "
                                    "told from what follows the temperature's course",
                                    *step_c));
  }
  const Courses courses(campaign, recording.observations);
  if (!courses.continuous()) {
    return cannot_judge(std::move(report),
                        "the temperature was not logged throughout: holes of more than five minutes");
  }
  Judges judges;
  for (const Sensor sensor : kSensors) judges[index_of(sensor)] = BranchJudge::of(recording, *plan, sensor);
  if (std::none_of(judges.begin(), judges.end(), [](const auto& judge) { return judge.has_value(); })) {
    return cannot_judge(std::move(report),
                        "no sensor has readings that scatter in two branches at common temperatures");
  }
  const std::vector<Mechanism> tried = mechanisms(recording, courses);
  const BranchFinding finding = search_branches(judges, tried);
  decide(finding, tried, judges, plan->halves, report);
  // No procedure repeats a recording without plateaus: the library's sentence stands for the simulated ranking.
  for (const NamedEffect& named : report.effects) {
    report.next.push_back({named.rivals.empty() ? std::string() : std::string(named.effect->experiment), {}});
  }
  report_gaps(finding, judges, report);
  report.not_testable = not_testable_by_branches(tried);
  return report;
}

}  // namespace soak::calib::gap::reduced
