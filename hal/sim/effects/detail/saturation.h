// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Output words that go no further than a rail: clipped at minus and plus the amplitude. No shape.
[[nodiscard]] std::unique_ptr<Effect> make_saturation(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
