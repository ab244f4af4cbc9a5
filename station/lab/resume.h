// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "station/config/plan.h"

namespace soak::station {

/// How a campaign that was cut short goes on.
struct WayBack {
  /// Steps of the plan in the order in which they are carried out first; after the last of them the plan goes on with
  /// the step that follows it. Not empty.
  std::vector<std::size_t> steps;
  std::string text;  ///< where the run goes on, for the log; empty where it begins
};

/// The way back into a plan of which the steps `ended` came to their end; `room_c` is where the chamber is now.
///
/// With on_break = resume the run goes on one visit before the one that was cut short, which is done again in full. A
/// unit's reading depends on how its temperature came there (hysteresis), so the chamber first drives to the set points
/// before that visit at which the temperature last turned, and the units settle there: from then on they see what they
/// would have seen without the break. Where the plan itself comes from the room in that direction, so does the way
/// back. With repeat_run the run begins again; one that begins at a plateau (power.cycle_at_visit) is approached in the
/// same manner. A run all of whose visits are done is not touched again.
/// Where all steps have ended the last one, which records nothing, is carried out again.
[[nodiscard]] WayBack way_back(const Plan& plan, const std::set<std::size_t>& ended, double room_c);

/// How the temperature stands after a suspension.
struct Whereabouts {
  double air_c = 0.0;
  double room_c = 0.0;
  bool was_away = false;  ///< the air has been away from the set point meanwhile
};

/// The way back to the begin of the visit that step `step` belongs to, within the run: its units have stayed on. Where
/// the air has stayed at the plateau, or between it and the one before it on the way there, that is the visit's first
/// step alone. Else the chamber first drives to where the temperature last turned, as in way_back(). Not empty.
[[nodiscard]] std::vector<std::size_t> way_to_visit(const Plan& plan, std::size_t step, const Whereabouts& now);

}  // namespace soak::station
