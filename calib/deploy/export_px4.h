// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/export_loss.h"

namespace soak::calib {

inline constexpr int kPx4Instances = 4;

/// Where in PX4 the parameters go.
struct Px4Options {
  int instance = 0;  ///< 0 to 3: the n of TC_An_*, TC_Gn_*
  /// Device ids that PX4 binds the parameters to (CAL_ACCn_ID, CAL_GYROn_ID on the vehicle); absent: left out, and PX4
  /// applies nothing until the user has set them.
  std::optional<std::int32_t> accel_id;
  std::optional<std::int32_t> gyro_id;
  bool relative_accel = false;  ///< the accelerometers' bias has no level of its own (SensorFit::relative)
};

/// A PX4 parameter file (tab-separated "1 1 NAME VALUE TYPE", type 6 int32, 9 float32) with TC_A_ENABLE, TC_G_ENABLE
/// and TC_An_*, TC_Gn_*: per axis offset = X0 + X1 d + X2 d² + X3 d³ with d = T − TREF, T held at [TMIN, TMAX], which
/// PX4 subtracts from the raw value in rad/s, m/s². Each cubic is the least squares fit to the bias curve over the
/// range in which the three axes are valid, weighted by 1/ci95²; TREF is the middle of that range. A kind without
/// sensors is left out. Refuses an instance out of range, a kind with one or two axes, and axes without a common range.
[[nodiscard]] base::Result<AutopilotFile> export_px4(const Calibration& calibration, const Px4Options& options);

}  // namespace soak::calib
