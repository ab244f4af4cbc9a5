// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/result.h"
#include "calib/calibration.h"
#include "calib/file/curve_section.h"
#include "calib/runtime/soak_runtime.h"

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

/// Samples a curve that check_curve() accepts. Refuses one that is not finite in the valid range, is a scale factor
/// error beyond ±500,000 ppm, or has a gap between its rules where every strength is below 1e-30.
[[nodiscard]] base::Result<SampledCurve> sample(const Curve& curve, const SensorCalibration& sensor, Quantity quantity);

/// Middle and half of the sampled values as float32 numbers.
[[nodiscard]] OutputScale output_scale(const SampledCurve& curve);

/// Compares the deployment runtime with the samples. The section holds what docs/blob-format.md 0x0030 says; refuses a
/// curve that differs by more than the page allows.
[[nodiscard]] base::Result<Section> float32_bound(const soak_cal& loaded, const SampledCurve& curve, Sensor sensor,
                                                  Quantity quantity);

}  // namespace soak::calib::file
