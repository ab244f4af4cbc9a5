// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Vibration of the compressor that the sensors rectify: 1 while it runs. The vibration itself rises and falls with the
/// spin-up time and is rectified by its square.
///
/// Shape: spin_up_s 1 ... 8.
[[nodiscard]] std::unique_ptr<Effect> make_vibration_rectification(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
