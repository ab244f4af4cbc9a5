// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// Sensing axes of accelerometers that bend with temperature: off-axis force in m/s² times the kelvins above 25 °C. The
/// amplitude is in rad/K. Both off-axis elements are drawn for each accelerometer.
///
/// Shape: c_xy, c_xz, c_yx, ... : ±0.5 ... 1.
[[nodiscard]] std::unique_ptr<Effect> make_cross_axis(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
