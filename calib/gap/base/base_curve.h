// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/gap/observations/observations.h"

namespace soak::calib::gap {

/// Cardinal basis of the natural cubic spline through given knots: weight k is 1 at knot k and 0 at all others, so that
/// coefficients are values at the knots. Beyond the ends straight lines. One knot: a constant; two: a line.
class LevelSpline {
 public:
  explicit LevelSpline(std::vector<double> knots);

  /// Weights of the knots' values in the value at `x`; their sum is 1.
  [[nodiscard]] Eigen::RowVectorXd weights(double x) const;
  /// The same, a row for each of many.
  [[nodiscard]] Eigen::MatrixXd weights(const std::vector<double>& x) const;
  /// Weights of the knots' values in the slope at `x`; their sum is 0.
  [[nodiscard]] Eigen::RowVectorXd slope_weights(double x) const;

 private:
  std::vector<double> knots_;
  Eigen::MatrixXd second_;  ///< second derivatives at the knots = second_ · values
};

/// The saturated base of one sensor: what a thermal model without any missing effect could follow at best. Columns, one
/// row per observation: a free level per plateau temperature (joined by a natural cubic spline, as visits settle some
/// tenths of a kelvin apart) and, per level, what the spline's slope is off there; accelerometers with positions also a
/// free scale error per plateau and two constant off-axis terms; then one offset per run but the first.
///
/// Levels 15 K apart do not say how steep the curve is between them. Visits that settle below the set point when
/// heating and above it when cooling would then make a wrong slope look like hysteresis.
struct BaseDesign {
  Eigen::MatrixXd columns;
  Eigen::Index levels = 0;   ///< the first so many columns are the levels of the bias, as many more those of its slope
  Eigen::Index offsets = 0;  ///< the last so many columns are run offsets
};

/// `temp_c`: the temperature that the base is a function of, one per observation (the sensor's own thermometer, or what
/// an accepted term makes of it).
[[nodiscard]] BaseDesign base_design(const Observations& observations, Sensor sensor,
                                     const std::vector<double>& temp_c);

/// Standard deviation of what the spline's slope is off at each knot, per kelvin, over the distance h of the levels:
/// inside, the largest distance of an inner level from the spline through all others, over h (features are local: a
/// mean would not do); at the ends, where a natural spline takes the curve for straight, 0.3 of the last second
/// difference over h if that is more (the error of its slope for a parabola is h f''·0.29). Infinite where a single
/// level says nothing.
[[nodiscard]] Eigen::VectorXd slope_sigmas(const std::vector<double>& level_c, const Eigen::VectorXd& levels);

/// Slope against temperature of what `coefficients` of the base say, at each observation: per kelvin.
[[nodiscard]] Eigen::VectorXd base_slope(const Observations& observations, Sensor sensor,
                                         const std::vector<double>& temp_c, const Eigen::VectorXd& coefficients);

}  // namespace soak::calib::gap
