// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// The position before this one is not forgotten: the part of the last up vector along a direction of the body that was
/// drawn, for as long as the unit rests in the next position. No shape.
[[nodiscard]] std::unique_ptr<Effect> make_position_memory(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
