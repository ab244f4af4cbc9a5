// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Noise that grows with temperature: its standard deviation is that at 25 °C times e^(a·(T − 25 °C)), with the
/// amplitude a per kelvin. No shape.
[[nodiscard]] std::unique_ptr<Effect> make_noise_vs_temperature(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
