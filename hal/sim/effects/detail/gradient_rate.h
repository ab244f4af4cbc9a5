// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// A lid that the air heats before the board: proportional to how fast the difference between air and unit changes, 1
/// at 1 K/min, smoothed by the heat capacity of the lid.
///
/// Shape: smoothing_s 60 ... 240.
[[nodiscard]] std::unique_ptr<Effect> make_gradient_rate(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
