// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// The unit sits a little crooked, each time it is mounted in another way: a small rotation θ of the body, θ × f for
/// the accelerometers. Its three parts are Gaussian for each mounting; the amplitude is the standard deviation of the
/// angle, √3 times that of one part, in degrees. No shape.
[[nodiscard]] std::unique_ptr<Effect> make_fixture_tilt(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
