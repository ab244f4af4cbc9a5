// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/detail/section.h"

namespace soak::calib::file {

/// Section 0x0023 (docs/blob-format.md §4) of what the calibration states of its couplings; absent where it states
/// nothing. Refuses uncertainties that are negative, not finite, or of a matrix that the calibration does not have.
[[nodiscard]] base::Result<std::optional<Section>> coupling_section(const Calibration& calibration);

/// Takes over a payload that soak_load() has accepted.
void read_couplings(const std::uint8_t* payload, Calibration& calibration);

}  // namespace soak::calib::file
