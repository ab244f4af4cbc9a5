// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "calib/estimate/unit_rows.h"

namespace soak::calib {

/// Refuses runs that no inertial unit can have given, before the data gate leaves anything out: none at all, readings
/// beyond 1e6 deg/s or m/s², a sensor with the same number throughout a run, accelerometers whose readings up and down
/// are not those of gravity to 20 %.
[[nodiscard]] base::Status check_readings(const UnitInput& input);

}  // namespace soak::calib
