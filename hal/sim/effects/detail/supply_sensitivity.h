// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// A reference that follows the supply: volts above 5 V. No shape.
[[nodiscard]] std::unique_ptr<Effect> make_supply_sensitivity(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
