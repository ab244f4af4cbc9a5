// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace soak::calib::gap {

/// Cardinal basis of the natural cubic spline through given knots: weight k is 1 at knot k and 0 at all others, so that
/// coefficients are values at the knots. Beyond the ends straight lines. One knot: a constant; two: a line.
class LevelSpline {
 public:
  explicit LevelSpline(std::vector<double> knots);

  /// Weights of the knots' values in the value at `x`; their sum is 1.
  [[nodiscard]] Eigen::RowVectorXd weights(double x) const;
  /// Weights of the knots' values in the slope at `x`; their sum is 0.
  [[nodiscard]] Eigen::RowVectorXd slope_weights(double x) const;

 private:
  std::vector<double> knots_;
  Eigen::MatrixXd second_;  ///< second derivatives at the knots = second_ · values
};

}  // namespace soak::calib::gap
