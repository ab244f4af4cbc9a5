// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Output words with coarse steps: the nearest multiple of the amplitude. No shape.
[[nodiscard]] std::unique_ptr<Effect> make_quantization(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
