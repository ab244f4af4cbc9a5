// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/sim/config/campaign_config.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {

/// A power-on of every unit, whose offsets the truth lists.
struct ListedRun {
  std::string label;
  int run = 0;  ///< as power_on_offset() counts
};

/// The power-ons that a truth lists.
struct ListedRuns {
  std::vector<ListedRun> runs;
  std::optional<ListedRun> verification;
};

/// All runs of a campaign and its verification run.
[[nodiscard]] ListedRuns campaign_runs(const CampaignConfig& config);

/// `[a, b, ...]` of what `text_of` makes of each item.
template <class Items, class TextOf>
[[nodiscard]] std::string json_list(const Items& items, TextOf text_of) {
  std::string text = "[";
  for (const auto& item : items) text += (text.size() > 1 ? ", " : "") + text_of(item);
  return text + "]";
}

/// JSON text of what is true of the units, the first of which is number 1, for judging what was found out about them.
/// Its format stands in README.md.
[[nodiscard]] std::string truth_json(const CampaignConfig& config, const std::vector<SimulatedUnit>& units,
                                     const ListedRuns& listed);

}  // namespace soak::hal::sim
