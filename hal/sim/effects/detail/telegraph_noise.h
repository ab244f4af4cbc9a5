// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Random telegraph noise: a trap in the electronics that is full (+1) or empty (−1); both states last exponentially
/// distributed times.
///
/// Shape: mean_stay_s 600 ... 5000.
[[nodiscard]] std::unique_ptr<Effect> make_telegraph_noise(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
