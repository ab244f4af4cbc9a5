// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Stress of the mount that creeps after each repositioning: every turn of the up vector adds its part along a
/// direction of the body that was drawn (2 at most), which then decays.
///
/// Shape: decay_s 150 ... 900.
[[nodiscard]] std::unique_ptr<Effect> make_reposition_creep(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
