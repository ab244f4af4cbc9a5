// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "anfis/data/training_data.h"
#include "base/result.h"
#include "calib/curve/calibration.h"

namespace soak::calib {

/// A curve fitted to rows, in the form in which it can be deployed.
struct FittedCurve {
  Curve curve;
  /// Variance of the curve at a temperature for rows whose variances are as stated by their weights (and groups).
  std::function<double(double)> variance;
  double parameters = 0.0;    ///< effective number of them
  double whitened_rss = 0.0;  ///< rᵀV⁻¹r of the rows it was fitted to
};

/// Polynomial of given degree by generalised least squares under the rows' weights and random group offsets. Degree up
/// to 3 deploys as one cubic piece, higher ones as 64 Hermite pieces (error below 1e-6 of the curve's span for a
/// quintic). Refuses fewer distinct temperatures than coefficients.
[[nodiscard]] base::Result<FittedCurve> fit_polynomial(const anfis::TrainingData& data, int degree);

/// Natural cubic smoothing spline with knots at the clusters of temperatures (0.5 K apart or more, at most 40), its
/// smoothness chosen by generalised cross-validation [Wahba 1990 ch. 4]; the variance is the Bayesian one, which covers
/// the smoothing bias on average (Nychka 1988). Refuses fewer than three distinct temperatures.
[[nodiscard]] base::Result<FittedCurve> fit_smoothing_spline(const anfis::TrainingData& data);

/// Middles of the clusters of temperatures that lie closer together than `apart_c`, at most `most` of them, rising.
[[nodiscard]] std::vector<double> temperature_clusters(std::vector<double> temps_c, double apart_c, std::size_t most);

}  // namespace soak::calib
