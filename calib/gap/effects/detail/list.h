// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/gap/effects/effect.h"

namespace soak::calib::gap {

/// One maker per file of this folder.
[[nodiscard]] Effect thermal_hysteresis();
[[nodiscard]] Effect temperature_rate();
[[nodiscard]] Effect sensor_lag();
[[nodiscard]] Effect warmup_transient();
[[nodiscard]] Effect g_sensitivity();
[[nodiscard]] Effect earth_rate();
[[nodiscard]] Effect cross_axis();
[[nodiscard]] Effect fixture_tilt();
[[nodiscard]] Effect scale_nonlinearity();
[[nodiscard]] Effect vibration_rectification();
[[nodiscard]] Effect supply_sensitivity();

}  // namespace soak::calib::gap
