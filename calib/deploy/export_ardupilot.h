// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/export_loss.h"

namespace soak::calib {

inline constexpr int kArduPilotInstances = 3;
inline constexpr double kArduPilotReference_c = 35.0;

/// Where in ArduPilot the parameters go.
struct ArduPilotOptions {
  int instance = 0;             ///< 0 to 2: IMU 1 to 3
  bool relative_accel = false;  ///< the accelerometers' bias has no level of its own (SensorFit::relative)
};

/// An ArduPilot parameter file ("NAME VALUE") with INS_TCALn_*. The correction is −p(T) + p(CALTEMP) − OFFS with
/// p(T) = 1e-6 (C1 d + C2 d² + C3 d³), d = T − 35 °C, both temperatures held at [TMIN, TMAX], one range for all six
/// sensors; rad/s, m/s². The cubic is the least squares fit with a free constant to the bias curve, weighted by
/// 1/ci95². Its constant part is written as INS_GYRnOFFS, INS_ACCnOFFS together with the temperature that they hold for
/// (INS_*_CALTEMP: 35 °C, or the end of the range nearest to it): one without the other would move every correction.
/// For accelerometers without a level of their own both are left out. A kind without sensors gets zero coefficients.
/// Refuses an instance out of range, a kind with one or two axes, and sensors without a common range.
[[nodiscard]] base::Result<AutopilotFile> export_ardupilot(const Calibration& calibration,
                                                           const ArduPilotOptions& options);

}  // namespace soak::calib
