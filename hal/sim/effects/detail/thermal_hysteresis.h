// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Stress that follows the temperature with play (Prandtl and Ishlinskii): eight play operators of different
/// half-widths, each of which moves only when the temperature has used up its play. What they stay behind, each
/// relative to its half-width, is averaged: +1 after a long way up, −1 after a long way down, whatever the speed and
/// however long ago. Grows or shrinks with temperature by `slope_pk` about 25 °C.
///
/// Shape: widest_c 4 ... 16 (half-width of the widest play), slope_pk ±0.006.
[[nodiscard]] std::unique_ptr<Effect> make_thermal_hysteresis(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
