// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "base/result.h"
#include "calib/verification.h"

namespace soak::station {

/// Reads limits from TOML: a table [limits] with keys gyro, accel (all three axes) and gyro_x ... accel_z (one axis,
/// which wins), in deg/s and m/s². Refuses unknown keys and values that are not positive numbers, naming the line.
[[nodiscard]] base::Result<calib::Limits> read_limits(const std::filesystem::path& path);

}  // namespace soak::station
