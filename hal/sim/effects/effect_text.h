// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "hal/sim/effects/drawn_effect.h"
#include "hal/sim/effects/shape_draws.h"

namespace soak::hal::sim {

/// JSON object {name: value} of a shape.
[[nodiscard]] std::string shape_json(const std::vector<ShapeParameter>& shape);

/// JSON list of what [[hidden]] does to the `number`-th unit of soaksim: of each effect name, amplitude and unit per
/// sensor, and shape. Every effect must state its amplitude.
[[nodiscard]] std::string lab_effects_json(const CampaignConfig& config, int number);

}  // namespace soak::hal::sim
