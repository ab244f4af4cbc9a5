// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// The sensing elements are a thermal node of their own behind the one that the thermometer is part of. With τ the
/// amplitude in seconds: dT_element/dt = (T − T_element)/τ. All sensors of the unit share it. No shape.
[[nodiscard]] std::unique_ptr<Effect> make_sensor_lag(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
