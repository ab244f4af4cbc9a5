// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/gap/experiment/detail/proposed_run.h"

namespace soak::calib::gap {

/// One more run that the laboratory could make.
struct Action {
  std::string name;               ///< "longer soak (36 min instead of 18)"
  std::string procedure;          ///< of those that come with Soak, by name; empty = that of the campaign
  std::vector<ProposedRun> runs;  ///< two where the units are switched off and on between
};

/// The same once more; half the ramp rate, and twice it where the air takes long enough for that to show; a soak of
/// twice the time; a temperature that turns back half-way up; a power cycle in the middle; the fixture turned by
/// 90 degrees. Those that this campaign's temperatures leave no room for are left out.
[[nodiscard]] std::vector<Action> actions(const RunTemplate& source);

/// Set points every 5 K up to 15 K about `spot_c`, within the temperatures of the template, upwards and back. Nothing
/// where the template's own are as close.
[[nodiscard]] std::optional<Action> fine_grid(const RunTemplate& source, double spot_c);

/// Why a turn of the fixture would show nothing; nothing where it can show.
[[nodiscard]] std::optional<std::string> what_a_turn_needs(const RunTemplate& source);

}  // namespace soak::calib::gap
