// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// One more run, and how far it would set an effect and its rivals apart.
struct Experiment {
  std::string action;     ///< "longer soak (36 min instead of 18)"
  std::string procedure;  ///< of those that come with Soak, by name; empty = that of the campaign
  double hours = 0.0;     ///< of the chamber, without pre-flight and the way back to the room
  double sigma = 0.0;     ///< expected, beyond what the runs made tell; 0 = nothing. Of rivals that one action tells
                          ///< together the least
  std::string needs;      ///< what must be known first; sigma is 0 then
};

/// What would tell an effect from its rivals.
struct NextExperiment {
  std::string text;                     ///< a sentence; empty where there is no rival
  std::vector<Experiment> experiments;  ///< squared sigma per hour falling
};

/// Simulates each feasible action (experiment_actions.h) as one more run of the campaign, with the temperatures of its
/// own logs, and ranks them by the squared distance that they add (discrimination.h) per hour. Rivals that no action
/// tells are named in the text with the library's sentence. `plain`: the base without terms, fitted to all runs, and
/// the observations as the search saw them; `effects`: all that were named. Nothing is computed where effects[which]
/// has no rivals. An effect that every mounting draws anew predicts nothing for the next run: there the library's
/// sentence stands alone.
[[nodiscard]] NextExperiment next_experiment(const LoggedCampaign& campaign, const CampaignModel& plain,
                                             const std::vector<NamedEffect>& effects, std::size_t which);

}  // namespace soak::calib::gap
