// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Moisture in the package, driven out by heat and taken up again in the cold. Water content m between 0 and 1:
/// dm/dt = (1 − m)/τ_up − m/τ_dry · 2^((T − 50 °C)/12), starting full.
///
/// Shape: uptake_h 4 ... 20, drying_h 0.5 ... 3 (at 50 °C).
[[nodiscard]] std::unique_ptr<Effect> make_moisture(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
