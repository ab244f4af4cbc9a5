// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/low_pass_curve.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace soak::calib::signal::allan_fit {
namespace {

/// Midpoints per corner frequency and per period of w.
constexpr double kPerCorner = 50.0;
constexpr double kPerPeriod = 12.0;

double square(double x) { return x * x; }

}  // namespace

double LowPassCurve::lag() const {
  const double corner = filter_.corner_hz * interval_s_;
  const double steps = std::ceil(0.5 * kPerCorner / std::min(0.5, corner));
  double sum = 0.0;
  for (double i = 0.5; i < steps; ++i) {
    const double f = 0.5 * i / steps;
    sum += (1.0 - filter_.gain(f / interval_s_)) / square(std::sin(std::numbers::pi * f));
  }
  return 0.5 / steps * sum;
}

LowPassCurve::Point LowPassCurve::at(double m, double differences) const {
  const double corner = filter_.corner_hz * interval_s_;
  const double steps = std::ceil(0.5 * std::max(kPerCorner / std::min(0.5, corner), kPerPeriod * m));
  double sum = 0.0;
  double squares = 0.0;
  for (double i = 0.5; i < steps; ++i) {
    const double f = 0.5 * i / steps;
    const double window =
        2.0 * std::pow(std::sin(std::numbers::pi * f * m), 4) / square(m * std::sin(std::numbers::pi * f));
    const double density = filter_.gain(f / interval_s_) * window;
    sum += density;
    squares += density * density;
  }
  const double step = 0.5 / steps;
  return {2.0 * step * sum, 2.0 * differences * step * sum * sum / squares};
}

}  // namespace soak::calib::signal::allan_fit
