// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/export.h"

namespace soak::calib::exporting {

/// A valid range whose ends are float32 numbers.
struct TempRange {
  double min_c = 0.0;
  double max_c = 0.0;
};

/// c[0] + c[1] d + c[2] d² + c[3] d³ with d = T − reference.
using Cubic = std::array<double, 4>;

/// Points of the grid that fits and losses are computed on.
inline constexpr std::size_t kGridPoints = 2001;

/// Evenly spaced temperatures of the range, both ends included.
[[nodiscard]] std::vector<double> grid_of(TempRange range);

/// The sensors of one kind, in the order x, y, z; none if the calibration has none of it. Refuses one or two of three,
/// as `target` corrects the three axes together, and sensors over thermometers of their own, as it has one for them.
[[nodiscard]] base::Result<std::vector<const SensorCalibration*>> three_axes(const Calibration& calibration, bool gyro,
                                                                             std::string_view target);

/// The range in which every one of the sensors is valid, its ends rounded to float32. Refuses sensors without a common
/// range.
[[nodiscard]] base::Result<TempRange> common_range(std::span<const SensorCalibration* const> sensors);

/// Weight of each temperature in the fit: 1/u² with u the half-width of the curve's 95 % band, u taken as no less than
/// a third of its median; 1 throughout where the band is not known.
[[nodiscard]] std::vector<double> fit_weights(const UncertaintyTable& uncertainty, std::span<const double> temps_c);

/// The cubic about `reference_c` that minimises Σ w_i (cubic(T_i) − bias(T_i))² over grid_of(range), w = fit_weights().
[[nodiscard]] Cubic best_cubic(const SensorCalibration& sensor, TempRange range, double reference_c);

/// What `correction` (float32, as the target computes it) loses of the sensor's bias curve.
[[nodiscard]] CubicLoss loss_of(const SensorCalibration& sensor, TempRange range, double reference_c,
                                const std::function<float(float)>& correction);

}  // namespace soak::calib::exporting
