// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/signal/spectrum/low_pass.h"

namespace soak::calib::signal::allan_fit {

/// White noise behind a low-pass, sampled; time in sample intervals.
class LowPassCurve {
 public:
  LowPassCurve(const LowPass& filter, double interval_s) : filter_(filter), interval_s_(interval_s) {}

  /// lag = sum_k |k| r_k, r the autocovariance for a density of 1 at frequency 0
  ///     = integral over (0, 1/2) of (1 - gain)/sin^2(pi f).
  /// Beyond the filter's memory the phase has the covariance -(|t|/2), and -lag/2 instead of 0 at t = 0: the Allan
  /// variance is 1/m - 1.5 lag/m^2.
  [[nodiscard]] double lag() const;

  /// Allan variance at any m, and the effective degrees of freedom of an estimate of it that averages so many
  /// differences:
  ///   2 integral of gain w,  2 differences (integral of gain w)^2 / integral of (gain w)^2,
  ///   w = 2 sin^4(pi f m)/(m sin(pi f))^2 over (0, 1/2).
  struct Point {
    double variance = 0.0;
    double degrees_of_freedom = 0.0;
  };
  [[nodiscard]] Point at(double m, double differences) const;

 private:
  LowPass filter_;
  double interval_s_;
};

}  // namespace soak::calib::signal::allan_fit
