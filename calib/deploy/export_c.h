// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "calib/curve/calibration.h"

namespace soak::calib {

/// The calibration file as a C99 header: the bytes as a constant array for soak_runtime.h, under a comment that says
/// where they come from, what they were measured with (references, waivers) and how to use them. A header made from
/// simulated data compiles only where SOAK_ACCEPT_SIMULATED is defined. Fails as encode() does.
[[nodiscard]] base::Result<std::string> export_c(const Calibration& calibration);

}  // namespace soak::calib
