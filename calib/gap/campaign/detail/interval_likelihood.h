// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace soak::calib::gap {

/// Logarithm of the chance that a Gaussian value lies in an interval, with its derivatives by the Gaussian's mean.
struct IntervalLikelihood {
  double log_chance = 0.0;
  double score = 0.0;      ///< first derivative
  double curvature = 0.0;  ///< minus the second derivative; not below 0: the logarithm is concave
};

/// `low` < `high`: distances of the interval's ends from the mean; `sigma` > 0 in the same unit. Finite at any
/// distance.
[[nodiscard]] IntervalLikelihood interval_likelihood(double low, double high, double sigma);

}  // namespace soak::calib::gap
