// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/experiment/detail/experiment_actions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace soak::calib::gap {
namespace {

constexpr double kMinute_s = 60.0;
constexpr double kRoom_c = 23.0;  ///< as in history.cpp: where runs begin
constexpr double kTurn_deg = 90.0;
constexpr double kGrid_c = 5.0;
constexpr double kGridReach_c = 15.0;
constexpr std::size_t kLeastForALoop = 5;

ProposedRun same_run(const RunTemplate& source) {
  ProposedRun run;
  run.settling = source.settling;
  run.start_c = source.start_c;
  for (std::size_t v = 0; v < source.visits.size(); ++v) {
    const TemplateVisit& visit = source.visits[v];
    run.visits.push_back({v, visit.plateau_c, visit.rest_c, visit.soak_s, visit.sweep});
  }
  return run;
}

/// The visits in this order, with the time to soak that each had at its first place.
ProposedRun with_order(const RunTemplate& source, const std::vector<std::size_t>& order) {
  const ProposedRun all = same_run(source);
  ProposedRun run = all;
  run.visits.clear();
  for (const std::size_t v : order) {
    ProposedVisit visit = all.visits[v];
    if (!run.visits.empty()) {
      const double way_c = visit.temp_c - run.visits.back().temp_c;
      visit.sweep = way_c > 0.0 ? Sweep::up : Sweep::down;
    }
    run.visits.push_back(visit);
  }
  return run;
}

double typical_soak_s(const RunTemplate& source) {
  std::vector<double> soaks_s;
  for (std::size_t v = 1; v < source.visits.size(); ++v) soaks_s.push_back(source.visits[v].soak_s);
  if (soaks_s.empty()) return 0.0;
  const auto middle = soaks_s.begin() + static_cast<std::ptrdiff_t>(soaks_s.size() / 2);
  std::nth_element(soaks_s.begin(), middle, soaks_s.end());
  return *middle;
}

std::optional<Action> at_rate(const RunTemplate& source, double factor, const char* words) {
  const auto& rate_kps = source.settling.rate_kps;
  // Air that jumps has no rate; its unit is slowed down to half of what it then does.
  const double way_c = source.visits.size() > 1 ? std::abs(source.visits[1].rest_c - source.visits[0].rest_c) : 0.0;
  const double fastest_kps = source.settling.tau_s > 0.0 ? way_c / source.settling.tau_s : 0.0;
  const double now_kps = rate_kps.value_or(fastest_kps);
  if (!(now_kps > 0.0) || (factor > 1.0 && !rate_kps)) return std::nullopt;
  Action action{fmt::format("{} the ramp rate ({:.2g} K/min instead of {:.2g})", words, factor * now_kps * kMinute_s,
                            now_kps * kMinute_s),
                "other-ramp",
                {same_run(source)}};
  action.runs.front().settling.rate_kps = factor * now_kps;
  return action;
}

Action longer_soak(const RunTemplate& source) {
  const double now_s = typical_soak_s(source);
  Action action{fmt::format("longer soak ({:.0f} min instead of {:.0f})", 2.0 * now_s / kMinute_s, now_s / kMinute_s),
                "longer-soak",
                {same_run(source)}};
  for (ProposedVisit& visit : action.runs.front().visits) visit.soak_s *= 2.0;
  return action;
}

/// Visits of the longest way in one direction, in order.
std::vector<std::size_t> longest_way(const RunTemplate& source) {
  std::vector<std::size_t> best;
  std::vector<std::size_t> now;
  double direction = 0.0;
  for (std::size_t v = 0; v < source.visits.size(); ++v) {
    const double way_c = now.empty() ? 0.0 : source.visits[v].rest_c - source.visits[now.back()].rest_c;
    if (!now.empty() && direction != 0.0 && way_c * direction < 0.0) now.erase(now.begin(), now.end() - 1);
    if (!now.empty()) direction = way_c;
    now.push_back(v);
    if (now.size() > best.size()) best = now;
  }
  return best;
}

/// To the middle of the longest way, back to its first quarter, and on to its end.
std::optional<Action> minor_loop(const RunTemplate& source) {
  const std::vector<std::size_t> way = longest_way(source);
  if (way.size() < kLeastForALoop) return std::nullopt;
  const std::size_t middle = way.size() / 2;
  const std::size_t quarter = way.size() / 4;
  std::vector<std::size_t> order(way.begin(), way.begin() + static_cast<std::ptrdiff_t>(middle) + 1);
  for (std::size_t k = middle; k-- > quarter;) order.push_back(way[k]);
  order.insert(order.end(), way.begin() + static_cast<std::ptrdiff_t>(quarter) + 1, way.end());
  return Action{fmt::format("minor loop (back from {:g} to {:g} °C on the way)", source.visits[way[middle]].plateau_c,
                            source.visits[way[quarter]].plateau_c),
                "minor-loop",
                {with_order(source, order)}};
}

/// At the visit nearest the middle of the first half of the run, among those whose way from the temperature of the room
/// leads in the direction of their sweep: what a new run takes for its past is then what it was.
std::optional<Action> power_cycle(const RunTemplate& source) {
  const auto& visits = source.visits;
  std::optional<std::size_t> at;
  const auto off_middle = [&](std::size_t v) {
    return std::abs(static_cast<double>(v) - static_cast<double>(visits.size()) / 4.0);
  };
  for (std::size_t v = 1; v + 1 < visits.size(); ++v) {
    const bool outwards = visits[v].sweep == Sweep::up     ? visits[v].rest_c >= kRoom_c
                          : visits[v].sweep == Sweep::down ? visits[v].rest_c < kRoom_c
                                                           : false;
    if (outwards && (!at || off_middle(v) < off_middle(*at))) at = v;
  }
  if (!at) return std::nullopt;
  ProposedRun before = same_run(source);
  ProposedRun after = before;
  before.visits.resize(*at + 1);
  after.visits.erase(after.visits.begin(), after.visits.begin() + static_cast<std::ptrdiff_t>(*at));
  after.start_c = after.visits.front().temp_c;
  return Action{fmt::format("power cycle at {:g} °C in the middle of the run", visits[*at].plateau_c),
                "power-cycle",
                {std::move(before), std::move(after)}};
}

Action azimuth_turn(const RunTemplate& source) {
  Action action{fmt::format("azimuth turn of the fixture by {:g} degrees", kTurn_deg), "azimuth-turn", {}};
  action.runs.push_back(same_run(source));
  action.runs.front().turn_deg = kTurn_deg;
  return action;
}

std::size_t nearest_visit(const RunTemplate& source, double temp_c) {
  std::size_t best = 0;
  for (std::size_t v = 1; v < source.visits.size(); ++v) {
    if (std::abs(source.visits[v].rest_c - temp_c) < std::abs(source.visits[best].rest_c - temp_c)) best = v;
  }
  return best;
}

}  // namespace

std::vector<Action> actions(const RunTemplate& source) {
  std::vector<Action> list;
  const auto add = [&](std::optional<Action> action) {
    if (action) list.push_back(*std::move(action));
  };
  list.push_back({"repeat of the same procedure", "", {same_run(source)}});
  add(at_rate(source, 0.5, "half"));
  add(at_rate(source, 2.0, "twice"));
  list.push_back(longer_soak(source));
  add(minor_loop(source));
  add(power_cycle(source));
  if (!what_a_turn_needs(source)) list.push_back(azimuth_turn(source));
  return list;
}

std::optional<Action> fine_grid(const RunTemplate& source, double spot_c) {
  std::vector<double> levels_c;
  for (const TemplateVisit& visit : source.visits) levels_c.push_back(visit.rest_c);
  std::sort(levels_c.begin(), levels_c.end());
  const double low_c = std::max(levels_c.front(), spot_c - kGridReach_c);
  const double high_c = std::min(levels_c.back(), spot_c + kGridReach_c);
  double widest_c = 0.0;
  for (std::size_t k = 1; k < levels_c.size(); ++k) {
    if (levels_c[k] > low_c && levels_c[k - 1] < high_c) widest_c = std::max(widest_c, levels_c[k] - levels_c[k - 1]);
  }
  if (widest_c < 1.5 * kGrid_c) return std::nullopt;
  std::vector<double> set_points_c;
  for (double c = low_c; c < high_c + 0.5; c += kGrid_c) set_points_c.push_back(c);
  for (std::size_t k = set_points_c.size() - 1; k-- > 0;) set_points_c.push_back(set_points_c[k]);
  ProposedRun run = same_run(source);
  run.visits.clear();
  const double soak_s = typical_soak_s(source);
  for (std::size_t k = 0; k < set_points_c.size(); ++k) {
    const Sweep sweep = 2 * k < set_points_c.size() ? Sweep::up : Sweep::down;
    run.visits.push_back({nearest_visit(source, set_points_c[k]), set_points_c[k], set_points_c[k], soak_s, sweep});
  }
  return Action{fmt::format("grid of {:g} K from {:.0f} to {:.0f} °C and back", kGrid_c, low_c, high_c),
                "fine-grid",
                {std::move(run)}};
}

std::optional<std::string> what_a_turn_needs(const RunTemplate& source) {
  const auto& segments = source.run->run.segments;
  const bool known = std::all_of(segments.begin(), segments.end(), [](const Segment& segment) {
    return segment.position && segment.position->azimuth_deg.has_value();
  });
  if (known) return std::nullopt;
  return "the headings of the positions are not known: state azimuths_deg in the fixture's register map, or in the "
         "columns map of an import";
}

}  // namespace soak::calib::gap
