// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/detail/curve_section.h"

namespace soak::calib::file {

/// A curve in double precision on temperatures that float32 represents: evenly spaced over the valid range, closer
/// where the curve is steep.
struct SampledCurve {
  std::vector<float> temp_c;
  std::vector<double> value;
  double least = 0.0;
  double largest = 0.0;

  [[nodiscard]] double span() const { return largest - least; }
};

/// Samples a curve that check_curve() accepts. Refuses one that is not finite in the valid range, or is a scale factor
/// error beyond ±500,000 ppm.
[[nodiscard]] base::Result<SampledCurve> sample(const Curve& curve, const SensorCalibration& sensor, Quantity quantity);

/// A curve's section, and the section that states how far float32 is off (docs/blob-format.md 0x0030).
struct CheckedCurve {
  Section curve;
  Section bound;
};

/// The curve in the form that it has, compared with its samples by the deployment runtime. Refuses one that differs by
/// more than docs/blob-format.md allows, and a model with a gap between its rules where every strength is below 1e-30.
[[nodiscard]] base::Result<CheckedCurve> checked_curve(const Curve& curve, const SampledCurve& samples, Sensor sensor,
                                                       Quantity quantity);

}  // namespace soak::calib::file
