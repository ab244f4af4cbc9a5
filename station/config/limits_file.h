// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "base/result.h"
#include "calib/vocabulary/unit_type.h"
#include "settings/reader.h"

namespace soak::station {

/// Reads a table [limits], of a unit type's file or of one of its own: gyro, accel (all three axes), gyro_x ... accel_z
/// (one axis, which wins) in deg/s and m/s², and each of these with _scale_ppm behind it, in ppm. Values that are no
/// positive numbers become mistakes of the text; unknown keys do so at its end.
[[nodiscard]] calib::Limits read_limits_table(const settings::Table& table);

/// Reads a file that holds a table [limits] and nothing else. Refuses all mistakes at once, each with its line.
[[nodiscard]] base::Result<calib::Limits> read_limits(const std::filesystem::path& path);

/// Limits under the keys of one axis, in deg/s, m/s² and ppm: what read_limits_table() reads back.
[[nodiscard]] std::map<std::string, double> stated_limits(const calib::Limits& limits);

}  // namespace soak::station
