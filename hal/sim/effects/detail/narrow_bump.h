// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// A resonance or a phase change in the package at one temperature: a Lorentzian of half-width w at half height, or a
/// step that is smeared over w, 1/(1 + e^(−(T − T₀)/w)). Height 1.
///
/// Shape: is_step 0 or 1; centre_c, of a Lorentzian within 3 °C of a set point that is neither the first nor the last,
/// of a step in the middle third between two such; half_width_c 1.5 ... 4, of a step 0.3 ... 1.
[[nodiscard]] std::unique_ptr<Effect> make_narrow_bump(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
