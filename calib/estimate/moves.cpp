// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/moves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include "base/statistics.h"
#include "base/units.h"

namespace soak::calib {
namespace {

constexpr double kLongestMove_s = 60.0;
constexpr double kLongestMovesSession_s = 6.0 * 3600.0;
constexpr std::size_t kFewestMovePositions = 3;
constexpr double kLongestMoveGap_s = 0.05;
constexpr double kLongestMoveGapIntervals = 3.5;
constexpr double kMoveAtRange = 0.998;  ///< of the range: what counts as its end
constexpr std::size_t kRepeats = 3;     ///< neighbours at the extreme value that no turn by hand gives
constexpr double kSlowest_dps = 20.0;   ///< below it an extreme value may repeat by resolution

double move_interval_s(const std::vector<double>& t_s) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < t_s.size(); ++i) intervals.push_back(t_s[i] - t_s[i - 1]);
  return intervals.empty() ? 0.0 : base::median(intervals);
}

bool has_gaps(const Move& move) {
  const double longest_s = std::max(kLongestMoveGap_s, kLongestMoveGapIntervals * move_interval_s(move.t_s));
  double before_s = move.from_s;
  for (const double t_s : move.t_s) {
    if (t_s - before_s > longest_s) return true;
    before_s = t_s;
  }
  return move.t_s.size() < 2 || move.to_s - before_s > longest_s;
}

/// Whether a gyro is at the end of its range, or stays at its extreme value for some samples.
bool is_saturated(const Move& move, const std::optional<double>& range_dps) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double largest = 0.0;
    for (const Vector3& rate : move.rate_rps) largest = std::max(largest, std::abs(rate[axis]));
    if (range_dps && largest >= kMoveAtRange * *range_dps * base::kRadPerDeg) return true;
    if (largest < kSlowest_dps * base::kRadPerDeg) continue;
    std::size_t repeats = 0;
    for (const Vector3& rate : move.rate_rps) {
      repeats = std::abs(rate[axis]) == largest ? repeats + 1 : 0;
      if (repeats >= kRepeats) return true;
    }
  }
  return false;
}

/// Middle of the angles that are stated during the movement; nothing where none is.
std::optional<double> stated_turn_rad(const Recording& recording, std::size_t first, std::size_t last) {
  std::vector<double> angles;
  for (const AuxiliaryChannel& channel : recording.auxiliary) {
    if (channel.name != kTurnChannel) continue;
    for (std::size_t i = first; i < last; ++i) {
      if (std::isfinite(channel.values[i]) && channel.values[i] != 0.0) angles.push_back(std::abs(channel.values[i]));
    }
  }
  if (angles.empty()) return std::nullopt;
  return base::median(angles) * base::kRadPerDeg;
}

Move move_between(const Recording& recording, const Segment& before, const Segment& after, const UnitType& type) {
  Move move;
  move.from_s = before.t_end_s;
  move.to_s = after.t_start_s;
  const auto& t_s = recording.t_s;
  const auto first = static_cast<std::size_t>(std::ranges::lower_bound(t_s, move.from_s) - t_s.begin());
  const auto last = static_cast<std::size_t>(std::ranges::upper_bound(t_s, move.to_s) - t_s.begin());
  for (std::size_t i = first; i < last; ++i) {
    const Vector3 rate = {recording.sensor[0][i], recording.sensor[1][i], recording.sensor[2][i]};
    if (std::ranges::any_of(rate, [](double x) { return !std::isfinite(x); })) continue;
    move.t_s.push_back(t_s[i]);
    move.rate_rps.push_back(rate);
  }
  move.turn_rad = stated_turn_rad(recording, first, last);
  if (is_saturated(move, type.gyro_range_dps)) {
    move.flaw = MoveFlaw::saturated;
  } else if (has_gaps(move)) {
    move.flaw = MoveFlaw::gaps;
  }
  return move;
}

}  // namespace

bool is_bench_session(std::span<const Segment> segments) {
  if (segments.empty() || segments.back().t_end_s - segments.front().t_start_s > kLongestMovesSession_s) return false;
  std::set<std::string> positions;
  for (const Segment& segment : segments) {
    if (segment.key.visit != segments.front().key.visit || !segment.plateau_c) return false;
    if (!turns(segment)) positions.insert(segment.key.position);
  }
  return positions.size() >= kFewestMovePositions;
}

std::vector<Move> moves_between(const Recording& recording, std::span<const Segment> segments, const UnitType& type) {
  std::vector<Move> moves;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (recording.sensor[axis].empty()) return moves;
  }
  for (std::size_t i = 1; i < segments.size(); ++i) {
    const Segment& before = segments[i - 1];
    const Segment& after = segments[i];
    const double lasts_s = after.t_start_s - before.t_end_s;
    if (turns(before) || turns(after) || lasts_s <= 0.0 || lasts_s > kLongestMove_s) continue;
    moves.push_back(move_between(recording, before, after, type));
  }
  return moves;
}

}  // namespace soak::calib
