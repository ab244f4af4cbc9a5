// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Accelerometers whose springs are not the same both ways: the square of the force along the axis, in g². No shape.
[[nodiscard]] std::unique_ptr<Effect> make_scale_nonlinearity(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
