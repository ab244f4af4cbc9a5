// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "hal/sim/effects/hidden_effects.h"

namespace soak::hal::sim {

/// A hidden effect of a unit in the laboratory of soaksim.
struct LabEffect {
  DrawnEffect drawn;
  double amplitude = 0.0;
};

/// What [[hidden]] does to the `number`-th unit of soaksim. Every effect must state its amplitude.
[[nodiscard]] std::vector<LabEffect> lab_effects(const CampaignConfig& config, int number);

/// What effects are told about the laboratory: its set points are those of [campaign].
[[nodiscard]] EffectSurroundings lab_surroundings(const CampaignConfig& config);

}  // namespace soak::hal::sim
