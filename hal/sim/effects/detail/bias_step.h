// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// A bond that gives way: at a random time after each power-on the bias steps, and stays so until the next power-on.
/// The waiting time is exponentially distributed, the height uniform in 0.5 ... 1 with random sign.
///
/// Shape: mean_wait_s 5000 ... 15000.
[[nodiscard]] std::unique_ptr<Effect> make_bias_step(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
