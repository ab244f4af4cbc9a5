// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

namespace soak::calib {

/// What all units of one make have in common. Values that are not known are absent, never guessed.
struct UnitType {
  std::string name = "generic";
  std::optional<double> temp_min_c;  ///< operating temperature rating
  std::optional<double> temp_max_c;
  std::optional<double> gyro_range_dps;
  std::optional<double> accel_range_mps2;
  std::optional<double> gyro_lsb_dps;  ///< output step
  std::optional<double> accel_lsb_mps2;
  /// +1 where the accelerometer of the axis that points up reads +g at rest (specific force), −1 where it reads −g.
  int sign_at_rest = +1;
};

}  // namespace soak::calib
