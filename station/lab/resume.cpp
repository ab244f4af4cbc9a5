// SPDX-License-Identifier: Apache-2.0
#include "station/lab/resume.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>

namespace soak::station {
namespace {

constexpr double kStillThere_k = 3.0;  ///< as for a door that was opened (temperature_steps.cpp)

/// The steps [first, end) of one plateau.
struct Visit {
  std::size_t first = 0;
  std::size_t end = 0;
  double temp_c = 0.0;
};

/// The visits among the steps [first, end).
std::vector<Visit> visits_between(const Plan& plan, std::size_t first, std::size_t end) {
  std::vector<Visit> visits;
  for (std::size_t i = first; i < end; ++i) {
    const Step& step = plan.steps[i];
    if (step.visit < 0) continue;
    const bool continues = !visits.empty() && visits.back().end == i && plan.steps[i - 1].visit == step.visit &&
                           plan.steps[i - 1].run == step.run;
    if (continues) {
      visits.back().end = i + 1;
    } else {
      visits.push_back({i, i + 1, step.temp_c});
    }
  }
  return visits;
}

/// Where the chamber's way to step `index` begins: behind the last time that it was brought back to the room's
/// temperature. A run may begin at a plateau where the one before it ended.
std::size_t begin_of_way(const Plan& plan, std::size_t index) {
  while (index > 0) {
    const Step& before = plan.steps[index - 1];
    if (before.kind == StepKind::warm_end || plan.runs[static_cast<std::size_t>(before.run)].preflight) break;
    --index;
  }
  return index;
}

int sign(double value) { return (value > 0.0) - (value < 0.0); }

/// The last visit before `target` at which the temperature turned; nothing where the way from the room is straight.
std::optional<std::size_t> turning_point(const Plan& plan, std::span<const Visit> before, const Visit& target,
                                         double room_c) {
  if (before.empty()) return std::nullopt;
  int direction = sign(target.temp_c - before.back().temp_c);
  if (direction == 0) {
    const calib::Sweep sweep = plan.steps[target.first].sweep;
    direction = sweep == calib::Sweep::up ? 1 : sweep == calib::Sweep::down ? -1 : 0;
  }
  const auto goes_on = [&](double from_c, double to_c) { return sign(to_c - from_c) * direction >= 0; };
  std::size_t k = before.size() - 1;
  while (k > 0 && goes_on(before[k - 1].temp_c, before[k].temp_c)) --k;
  if (k == 0 && goes_on(room_c, before[0].temp_c)) return std::nullopt;
  return k;
}

/// The visits at which the temperature must turn on the way from the room to `target`, in the order of the way. One is
/// enough where the room lies on the right side of it; else the temperature must first turn where it did before that.
std::vector<Visit> turning_points(const Plan& plan, std::span<const Visit> before, Visit target, double room_c) {
  std::vector<Visit> turns;
  while (const auto k = turning_point(plan, before, target, room_c)) {
    target = before[*k];
    before = before.first(*k);
    turns.insert(turns.begin(), target);
  }
  return turns;
}

std::optional<std::size_t> last_of_kind(const Plan& plan, StepKind kind, std::size_t first, std::size_t end) {
  for (std::size_t i = end; i > first; --i) {
    if (plan.steps[i - 1].kind == kind) return i - 1;
  }
  return std::nullopt;
}

/// Turned as the plan has it when the chamber drives to a visit's set point.
void turn_for(const Plan& plan, std::size_t way_begin, const Visit& visit, std::vector<std::size_t>& steps) {
  if (plan.steps[visit.first].kind == StepKind::move) return;
  if (const auto move = last_of_kind(plan, StepKind::move, way_begin, visit.first)) steps.push_back(*move);
}

/// Drives to a visit's set point and lets the units settle there, without recording.
void settle_at(const Plan& plan, std::size_t way_begin, const Visit& visit, std::vector<std::size_t>& steps) {
  turn_for(plan, way_begin, visit, steps);
  for (std::size_t i = visit.first; i < visit.end; ++i) {
    const Step& step = plan.steps[i];
    const bool settles = step.kind == StepKind::wait_stable && !step.after_turn;
    if (step.kind == StepKind::record || step.kind == StepKind::spin) break;
    if (step.kind == StepKind::move || step.kind == StepKind::set_temperature || settles) steps.push_back(i);
  }
}

/// The steps of a run before its first visit. The fixture stays as it was turned.
std::vector<std::size_t> prelude(const Plan& plan, const PlannedRun& run, const std::set<std::size_t>& ended) {
  std::vector<std::size_t> steps;
  for (std::size_t i = run.first_step; i <= run.last_step && plan.steps[i].visit < 0; ++i) {
    if (plan.steps[i].kind != StepKind::turn_fixture || !ended.contains(i)) steps.push_back(i);
  }
  return steps;
}

WayBack into_run(const Plan& plan, const PlannedRun& run, const std::set<std::size_t>& ended, double room_c);

/// Of a run that has all its visits only the end is left. Where the next one begins at the plateau at which this one
/// ended, the chamber must come there again.
WayBack behind_last_visit(const Plan& plan, const PlannedRun& run, const std::set<std::size_t>& ended, double room_c) {
  WayBack way{{*last_of_kind(plan, StepKind::power_off, run.first_step, run.last_step + 1)},
              fmt::format("{} has all its visits", run.label)};
  const std::size_t next = run.last_step + 1;
  if (next == plan.steps.size() || begin_of_way(plan, next) == next) return way;
  const WayBack rest = into_run(plan, plan.runs[static_cast<std::size_t>(plan.steps[next].run)], ended, room_c);
  way.steps.insert(way.steps.end(), rest.steps.begin(), rest.steps.end());
  const std::string& next_label = plan.runs[static_cast<std::size_t>(plan.steps[next].run)].label;
  return {way.steps, fmt::format("{} ({})", rest.text.empty() ? next_label + " begins" : rest.text, way.text)};
}

WayBack into_run(const Plan& plan, const PlannedRun& run, const std::set<std::size_t>& ended, double room_c) {
  const auto visits = visits_between(plan, run.first_step, run.last_step + 1);
  // Steps end in the order of the plan. Of a plateau that was skipped the last ones are missing.
  const auto behind_last = ended.upper_bound(run.last_step);
  const std::size_t begun = behind_last == ended.begin() ? 0 : *std::prev(behind_last) + 1;
  const auto has_ended = [&](const Visit& visit) { return visit.end <= begun; };
  const auto cut = std::find_if_not(visits.begin(), visits.end(), has_ended);
  const bool repeats = plan.procedure.on_break == BreakOutcome::repeat_run;
  if (!repeats && !visits.empty() && cut == visits.end()) {
    return behind_last_visit(plan, run, ended, room_c);
  }
  const bool from_begin = repeats || visits.empty() || cut == visits.begin();
  const auto target = from_begin ? visits.begin() : cut - 1;
  const std::size_t way_begin = begin_of_way(plan, run.first_step);
  const auto before = visits.empty() ? std::vector<Visit>() : visits_between(plan, way_begin, target->first);
  if (before.empty()) return {{run.first_step}, ""};
  WayBack way{prelude(plan, run, ended),
              fmt::format("{} goes on with the visit at {:+g} °C", run.label, target->temp_c)};
  for (const Visit& turn : turning_points(plan, before, *target, room_c)) {
    settle_at(plan, way_begin, turn, way.steps);
    way.text += fmt::format(", by way of {:+g} °C", turn.temp_c);
  }
  turn_for(plan, way_begin, *target, way.steps);
  way.steps.push_back(target->first);
  return way;
}

/// Whether the plan's chamber is at the visit's temperature in this step: behind the last step that drives it there.
bool is_at_plateau(const Plan& plan, std::size_t step, const Visit& target) {
  for (std::size_t i = step; i < target.end; ++i) {
    if (plan.steps[i].kind == StepKind::set_temperature) return false;
  }
  return true;
}

/// Whether the air can be where it is without having gone back: at the plateau, or on the way to it from the one
/// before.
bool has_kept_its_way(const Plan& plan, std::size_t step, std::span<const Visit> before, const Visit& target,
                      const Whereabouts& now) {
  if (now.was_away) return false;
  const bool is_there = is_at_plateau(plan, step, target);
  const double from_c = is_there ? target.temp_c : before.empty() ? now.room_c : before.back().temp_c;
  const auto [low_c, high_c] = std::minmax(from_c, target.temp_c);
  return now.air_c >= low_c - kStillThere_k && now.air_c <= high_c + kStillThere_k;
}

}  // namespace

std::vector<std::size_t> way_to_visit(const Plan& plan, std::size_t step, const Whereabouts& now) {
  const PlannedRun& run = plan.runs[static_cast<std::size_t>(plan.steps[step].run)];
  const auto visits = visits_between(plan, run.first_step, run.last_step + 1);
  const auto target = std::find_if(visits.begin(), visits.end(), [&](const Visit& visit) { return step < visit.end; });
  const std::size_t way_begin = begin_of_way(plan, run.first_step);
  const auto before = visits_between(plan, way_begin, target->first);
  std::vector<std::size_t> steps;
  if (!before.empty() && !has_kept_its_way(plan, step, before, *target, now)) {
    for (const Visit& turn : turning_points(plan, before, *target, now.air_c)) {
      settle_at(plan, way_begin, turn, steps);
    }
    turn_for(plan, way_begin, *target, steps);
  }
  steps.push_back(target->first);
  return steps;
}

WayBack way_back(const Plan& plan, const std::set<std::size_t>& ended, double room_c) {
  for (const PlannedRun& run : plan.runs) {
    if (ended.contains(run.last_step)) continue;
    // Of a run that is over nothing but the fixture's way back is left.
    const bool over = plan.steps[run.last_step].kind == StepKind::turn_fixture && ended.contains(run.last_step - 1);
    if (over) return {{run.last_step}, ""};
    if (run.preflight) return {{run.first_step}, ""};
    return into_run(plan, run, ended, room_c);
  }
  // soakd ended between the last step and the campaign's own end: that is reached through the last step again.
  return {{plan.steps.size() - 1}, "all its steps are done"};
}

}  // namespace soak::station
