// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Ageing: thousands of hours since the unit was first seen, by the calendar. No shape.
[[nodiscard]] std::unique_ptr<Effect> make_aging_drift(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
