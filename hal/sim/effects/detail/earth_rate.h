// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/sim/effects/effect.h"

namespace soak::hal::sim {

/// The rotation of the Earth, or of as much of it as nobody subtracts: a vertical part sin φ along up and a horizontal
/// part cos φ towards north, where the body axis after the vertical one points at the azimuth (see attitude.h). The
/// amplitude is the whole rate; 0.004178 °/s is the real one. While the fixture turns only the vertical part is felt.
///
/// Shape: latitude_deg 25 ... 65 and azimuth_deg 0 ... 360, unless [site] gives them.
[[nodiscard]] std::unique_ptr<Effect> make_earth_rate(const EffectOrder& order, ShapeDraws& shape);

}  // namespace soak::hal::sim
