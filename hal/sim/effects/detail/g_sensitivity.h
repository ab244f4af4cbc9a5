// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Gyros that feel specific force: a 3 × 3 matrix times the force in g. Of each gyro that is hit either its own axis
/// alone or all three; the largest element of the matrix is 1.
///
/// Shape: all_axes 0 or 1, and the nine elements m_xx ... m_zz (gyro, then force; of gyros that are not hit they do not
/// count).
[[nodiscard]] std::unique_ptr<Effect> make_g_sensitivity(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
