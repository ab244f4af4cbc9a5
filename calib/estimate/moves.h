// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/unit_type.h"

namespace soak::calib {

/// Channel of a recording with the angle that a unit is turned through by hand about the vertical, deg; its sign does
/// not matter, the gyros tell it. 0 or no value: not known.
inline constexpr std::string_view kTurnChannel = "turn_deg";

/// Why a movement says nothing of the gyros.
enum class MoveFlaw : std::uint8_t { none, saturated, gaps };

/// What the gyros read while a unit was moved from one rest to the next.
struct Move {
  double from_s = 0.0;  ///< end of the segment before, device time
  double to_s = 0.0;    ///< start of the segment after
  std::vector<double> t_s;
  std::vector<Vector3> rate_rps;   ///< as read
  std::optional<double> turn_rad;  ///< > 0: angle about the vertical, where the recording states one
  MoveFlaw flaw = MoveFlaw::none;
};

/// Whether the segments are those of a session at one temperature in which movements may show the gyros' scale: one
/// visit, three positions at rest or more, six hours at most.
[[nodiscard]] bool is_bench_session(std::span<const Segment> segments);

/// The movements between neighbouring segments, which are in the order of time; those of over a minute, and into or out
/// of a position in which the fixture turns, are left out. None without three gyros. A movement is flawed where a gyro
/// is at the range of the unit's type or repeats its extreme value, or where samples are missing for more than 50 ms
/// and three intervals.
[[nodiscard]] std::vector<Move> moves_between(const Recording& recording, std::span<const Segment> segments,
                                              const UnitType& type);

}  // namespace soak::calib
