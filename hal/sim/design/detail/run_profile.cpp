// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "base/random.h"
#include "hal/sim/campaign/run_plan.h"
#include "hal/sim/design/detail/campaign_timeline.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

constexpr Range kRampFactor = {0.5, 2.0};
constexpr Range kSoakFactor = {0.6, 2.0};
constexpr int kOrders = 4;

/// From `from` to `to`, `to` left out.
void append_way(int from, int to, int step, std::vector<int>& points) {
  for (int i = from; step > 0 ? i < to : i > to; i += step) points.push_back(i);
}

std::vector<int> from_cold(int count) {
  std::vector<int> points;
  append_way(0, count - 1, 1, points);
  append_way(count - 1, -1, -1, points);
  return points;
}

std::vector<int> from_hot(int count) {
  std::vector<int> points = from_cold(count);
  for (int& point : points) point = count - 1 - point;
  return points;
}

std::vector<int> from_middle(int count) {
  const int middle = count / 2;
  std::vector<int> points;
  append_way(middle, count - 1, 1, points);
  append_way(count - 1, 0, -1, points);
  append_way(0, middle + 1, 1, points);
  return points;
}

/// Up over the even ones and down over the odd ones, and the same again the other way round.
std::vector<int> in_double_steps(int count) {
  std::vector<int> points;
  append_way(0, count, 2, points);
  const int last_odd = count - 1 - count % 2;
  append_way(last_odd, -1, -2, points);
  std::vector<int> back(points.rbegin() + 1, points.rend());
  points.insert(points.end(), back.begin(), back.end());
  return points;
}

std::vector<int> ordered_set_points(int order, int count) {
  std::vector<int> points = order == 0   ? from_cold(count)
                            : order == 1 ? from_hot(count)
                            : order == 2 ? from_middle(count)
                                         : in_double_steps(count);
  points.resize(std::min(points.size(), static_cast<std::size_t>(2 * count - 1)));
  return points;
}

int drawn_index(base::Random& random, int count) {
  return std::min(static_cast<int>(std::floor(random.uniform() * count)), count - 1);
}

}  // namespace

std::vector<RunProfile> run_profiles(const DesignConfig& design, std::uint64_t seed) {
  base::Random random(seed, stream_of(Purpose::design_profile));
  const bool mixed = design.kind == DesignKind::mixed;
  const int first_order = drawn_index(random, kOrders);
  std::vector<RunProfile> profiles;
  for (int pass = 0; pass < design.runs; ++pass) {
    RunProfile profile{ordered_set_points(0, design.set_points), design.ramp_kps, design.soak_s, position_order(0)};
    if (mixed) {
      profile.set_points = ordered_set_points((first_order + pass) % kOrders, design.set_points);
      profile.ramp_kps /= drawn_from(random, kRampFactor);
      profile.soak_s *= drawn_from(random, kSoakFactor);
      profile.positions = position_order(pass);
    }
    profiles.push_back(std::move(profile));
  }
  if (mixed) {
    RunProfile& cycled = profiles[static_cast<std::size_t>(drawn_index(random, design.runs))];
    const auto visits = static_cast<int>(cycled.set_points.size());
    cycled.power_cycle_visit = visits / 3 + drawn_index(random, std::max(visits / 3, 1));
  }
  return profiles;
}

Mistakes drawn_mistakes(const DesignConfig& design, std::uint64_t seed) {
  base::Random random(seed, stream_of(Purpose::design_mistake));
  Mistakes mistakes;
  const int dropped = 1 + drawn_index(random, design.visits() - 1);
  const int apart = 1 + drawn_index(random, design.visits() - 1);  // another visit than the dropped one
  const PlannedVisit first{drawn_index(random, design.runs), dropped, -1};
  const PlannedVisit second{drawn_index(random, design.runs), (dropped + apart) % design.visits(),
                            drawn_index(random, 6)};
  if (design.dropped_visit) mistakes.dropped = first;
  if (design.wrong_position) mistakes.wrongly_labelled = second;
  return mistakes;
}

}  // namespace soak::hal::sim
