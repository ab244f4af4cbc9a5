// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "base/result.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// Thermal model of one sensor.
struct SensorFit {
  CurveFit bias;
  std::optional<CurveFit> scale;  ///< ppm
  bool relative = false;          ///< bias is relative to that at 25 °C
  std::vector<Warning> warnings;
};

/// Fits one sensor. The six sensors are independent: callers may run them in parallel.
[[nodiscard]] base::Result<SensorFit> fit_sensor(const UnitRows& rows, Sensor sensor, const CurveFitOptions& options);

}  // namespace soak::calib
