// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/detail/schedule.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace soak::calib {
namespace {

constexpr double kSamePlateau_c = 1.0;  ///< as in plateaus.h
constexpr double kSecondsPerHour = 3600.0;

bool is_wanted(Sweep sweep, Sweeps sweeps) {
  return sweeps == Sweeps::both || sweep == (sweeps == Sweeps::up ? Sweep::up : Sweep::down);
}

}  // namespace

RunSchedule schedule_of(const RunInput& run) {
  RunSchedule schedule;
  std::map<std::int32_t, PlateauVisit> visits;
  bool first = true;
  for (const Segment& segment : run.segments) {
    schedule.begin_s = first ? segment.t_start_s : std::min(schedule.begin_s, segment.t_start_s);
    first = false;
    if (!segment.plateau_c || segment.phase != Phase::soak) continue;
    const auto [found, is_new] = visits.try_emplace(
        segment.key.visit, PlateauVisit{segment.t_start_s, segment.t_end_s, *segment.plateau_c, segment.sweep});
    found->second.start_s = std::min(found->second.start_s, segment.t_start_s);
    found->second.end_s = std::max(found->second.end_s, segment.t_end_s);
  }
  for (const auto& [number, visit] : visits) schedule.visits.push_back(visit);
  std::ranges::sort(schedule.visits, {}, &PlateauVisit::start_s);
  return schedule;
}

int visit_at(const RunSchedule& schedule, double t_s) {
  const auto found = std::ranges::find_if(
      schedule.visits, [t_s](const PlateauVisit& visit) { return visit.start_s <= t_s && t_s <= visit.end_s; });
  return found == schedule.visits.end() ? -1 : static_cast<int>(found - schedule.visits.begin());
}

std::vector<double> set_points(const std::vector<RunSchedule>& runs) {
  std::vector<double> all;
  for (const RunSchedule& run : runs) {
    for (const PlateauVisit& visit : run.visits) all.push_back(visit.plateau_c);
  }
  std::ranges::sort(all);
  std::vector<double> different;
  for (const double plateau_c : all) {
    if (different.empty() || plateau_c - different.back() > kSamePlateau_c) different.push_back(plateau_c);
  }
  return different;
}

std::size_t nearest_set_point(const std::vector<double>& set_points_c, double plateau_c) {
  const auto nearest =
      std::ranges::min_element(set_points_c, {}, [plateau_c](double set) { return std::abs(set - plateau_c); });
  return static_cast<std::size_t>(nearest - set_points_c.begin());
}

std::vector<bool> every(std::size_t count, int step) {
  std::vector<bool> kept(count);
  for (std::size_t i = 0; i < count; i += static_cast<std::size_t>(step)) kept[i] = true;
  if (count > 0) kept.back() = true;
  return kept;
}

std::vector<bool> kept_visits(const RunSchedule& run, const std::vector<double>& set_points_c,
                              const std::vector<bool>& kept, Sweeps sweeps) {
  const std::size_t count = run.visits.size();
  std::vector<bool> keep(count);
  for (std::size_t v = 0; v < count; ++v) {
    const bool wanted =
        is_wanted(run.visits[v].sweep, sweeps) || (v + 1 < count && is_wanted(run.visits[v + 1].sweep, sweeps));
    keep[v] = wanted && kept[nearest_set_point(set_points_c, run.visits[v].plateau_c)];
  }
  return keep;
}

RunHours run_hours(const RunSchedule& run, const std::vector<bool>& kept) {
  RunHours hours;
  double joined_s = 0.0;
  double longest_s = 0.0;
  bool on_the_way = false;
  for (std::size_t v = 0; v < run.visits.size(); ++v) {
    const PlateauVisit& visit = run.visits[v];
    if (on_the_way) {
      const double way_s = visit.start_s - run.visits[v - 1].end_s;
      joined_s += way_s;
      longest_s = std::max(longest_s, way_s);
    }
    if (!kept[v]) continue;
    hours.most += joined_s + visit.end_s - visit.start_s;
    hours.least += longest_s + visit.end_s - visit.start_s;
    joined_s = longest_s = 0.0;
    on_the_way = true;
  }
  const double before_s = run.visits.empty() ? 0.0 : run.visits.front().start_s - run.begin_s;
  return {(hours.most + before_s) / kSecondsPerHour, (hours.least + before_s) / kSecondsPerHour};
}

}  // namespace soak::calib
