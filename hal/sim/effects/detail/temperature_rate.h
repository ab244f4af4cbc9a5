// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Thermal gradients in the unit, proportional to how fast its temperature changes: 1 at 1 K/min, times
/// 1 + slope_pk·(T − 25 °C).
///
/// Shape: slope_pk ±0.006.
[[nodiscard]] std::unique_ptr<Effect> make_temperature_rate(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
