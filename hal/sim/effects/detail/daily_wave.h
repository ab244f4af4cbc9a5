// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Something in the building that follows the time of day: a sine of one period per day.
///
/// Shape: peak_hour 0 ... 24 (UTC).
[[nodiscard]] std::unique_ptr<Effect> make_daily_wave(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
