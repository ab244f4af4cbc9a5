// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/curve/calibration.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/curve_data.h"
#include "calib/estimate/model_term.h"
#include "calib/vocabulary/sensor.h"

/// An accepted `narrow_bump`: a feature of a bias curve at one temperature, too narrow for what a family follows. It
/// depends on temperature alone, so that the deployed curve holds it.
namespace soak::calib {

/// height / (1 + ((T − centre)/width)²), in the unit of the curve.
struct CurveBump {
  double height = 0.0;
  double centre_c = 0.0;
  double width_c = 1.0;  ///< half width at half height, positive
  /// Of height, centre and width, in that order; all zero where nothing is known of it.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  /// Value at `temp_c` of a bump of height 1.
  [[nodiscard]] double shape(double temp_c) const;
  /// Standard uncertainty of the bump at `temp_c` (k = 1): of its height on top, of its place and width on the flanks.
  [[nodiscard]] double error_at(double temp_c) const;
};

/// The bump of a sensor among accepted terms; nothing where none acts on it.
[[nodiscard]] std::optional<CurveBump> bump_of(const std::vector<ModelTerm>& terms, Sensor sensor);

/// The curve with the bump, over the curve's own domain: cubic pieces that meet, and differ from the sum by some 1e-5
/// of its span. Some hundred pieces; 1024, what a calibration file holds, at most.
[[nodiscard]] SplineCurve with_bump(const Curve& curve, const CurveBump& bump);

/// The rows without the bump, for a fit.
[[nodiscard]] CurveData without_bump(CurveData data, const CurveBump& bump);

/// Adds the bump to what was fitted to rows without it: curve, points, and its uncertainty as contribution
/// `narrow_bump`.
void add_bump(const CurveBump& bump, CurveFit& fit);

}  // namespace soak::calib
