// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Electronics that warm up after power-on, a fast part and a slow one: 1 at power-on, then
/// s·e^(−t/τ_fast) + (1 − s)·e^(−t/τ_slow). Every power-on begins anew; 0 without power.
///
/// Shape: fast_s 150 ... 500, slow_s 1200 ... 5000, fast_share 0.2 ... 0.6.
[[nodiscard]] std::unique_ptr<Effect> make_warmup_transient(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
