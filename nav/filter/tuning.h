// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/drive/drive.h"
#include "nav/filter/sensor_model.h"

namespace soak::nav {

/// Sensor models from the rest at the beginning of a drive: noise coefficients are fitted to the Allan deviations of
/// its readings, sensor by sensor (sensor_model_of()), and say how biases move. White noise and the random walk of a
/// bias are those of the rest where they are above those of `otherwise`: driving shakes and warms a unit, a rest shows
/// only the least of it. A gyro's bias at the start is known to its white noise over the rest, what moves, and what a
/// heading that is wrong by `heading_sigma_rad` (of align()) leaves of the Earth's rotation in it; of an
/// accelerometer's the rest says nothing: `otherwise` does, and of scale factors. All of `otherwise` for a sensor whose
/// readings do not allow a fit, and for all sensors where the rest is shorter than 20 s.
[[nodiscard]] SensorModels tuned_at_rest(const Drive& drive, const SensorModels& otherwise, double heading_sigma_rad);

}  // namespace soak::nav
