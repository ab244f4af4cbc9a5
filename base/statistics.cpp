// SPDX-License-Identifier: Apache-2.0
#include "base/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace soak::base {
namespace {

/// Continued fraction of the incomplete beta function by Lentz' method.
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  double c = 1.0;
  double d = 1.0 / std::max(tiny, 1.0 - (a + b) * x / (a + 1.0));
  double value = d;
  for (int m = 1; m < 500; ++m) {
    const double md = m;
    const auto step = [&](double coefficient) {
      d = 1.0 + coefficient * d;
      if (std::abs(d) < tiny) d = tiny;
      c = 1.0 + coefficient / c;
      if (std::abs(c) < tiny) c = tiny;
      d = 1.0 / d;
      value *= d * c;
    };
    step(md * (b - md) * x / ((a + 2.0 * md - 1.0) * (a + 2.0 * md)));
    step(-(a + md) * (a + b + md) * x / ((a + 2.0 * md) * (a + 2.0 * md + 1.0)));
    if (std::abs(d * c - 1.0) < 1e-15) break;
  }
  return value;
}

/// Regularised incomplete beta function I_x(a, b).
double incomplete_beta(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1.0) / (a + b + 2.0)) return front * beta_fraction(a, b, x) / a;
  return 1.0 - front * beta_fraction(b, a, 1.0 - x) / b;
}

}  // namespace

double median(std::span<const double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> copy(values.begin(), values.end());
  const auto upper = copy.begin() + static_cast<std::ptrdiff_t>(copy.size() / 2);
  std::nth_element(copy.begin(), upper, copy.end());
  if (copy.size() % 2 == 1) return *upper;
  return 0.5 * (*std::max_element(copy.begin(), upper) + *upper);
}

double student_t_two_sided(double probability, double degrees_of_freedom) {
  const auto inside = [&](double t) {
    return 1.0 - incomplete_beta(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t));
  };
  const double half = 0.5 * (degrees_of_freedom + 1.0);
  const double front = 2.0 * std::exp(std::lgamma(half) - std::lgamma(0.5 * degrees_of_freedom)) /
                       std::sqrt(degrees_of_freedom * std::numbers::pi);
  double low = 0.0;
  double high = 1.0;
  while (inside(high) < probability && high < 1e12) high *= 2.0;
  // Newton's steps with the density, halving where one would leave the bracket.
  double t = 0.5 * (low + high);
  for (int i = 0; i < 200 && high - low > 1e-14 * high; ++i) {
    const double missing = probability - inside(t);
    (missing > 0.0 ? low : high) = t;
    const double step = missing / (front * std::exp(-half * std::log1p(t * t / degrees_of_freedom)));
    if (std::abs(step) <= 1e-9 * t) return t + step;  // the square of that is beyond the last digit
    t = t + step > low && t + step < high ? t + step : 0.5 * (low + high);
  }
  return t;
}

double chi_squared_upper_tail(double x, double degrees_of_freedom) {
  if (x <= 0.0) return 1.0;
  const double a = 0.5 * degrees_of_freedom;
  const double h = 0.5 * x;
  const double front = std::exp(a * std::log(h) - h - std::lgamma(a));
  if (h < a + 1.0) {  // series of the lower incomplete gamma function
    double term = 1.0 / a;
    double sum = term;
    for (int k = 1; k < 10000 && term > 1e-17 * sum; ++k) sum += term *= h / (a + k);
    return 1.0 - front * sum;
  }
  double b = h + 1.0 - a;  // continued fraction of the upper one
  double c = 1e300;
  double d = 1.0 / b;
  double value = d;
  for (int k = 1; k < 10000; ++k) {
    const double coefficient = -k * (k - a);
    b += 2.0;
    d = 1.0 / (coefficient * d + b);
    c = b + coefficient / c;
    value *= d * c;
    if (std::abs(d * c - 1.0) < 1e-15) break;
  }
  return front * value;
}

double f_upper_tail(double x, double numerator, double denominator) {
  if (x <= 0.0) return 1.0;
  return incomplete_beta(0.5 * denominator, 0.5 * numerator, denominator / (denominator + numerator * x));
}

double chi_squared_quantile(double probability, double degrees_of_freedom) {
  double low = 0.0;
  double high = std::max(1.0, degrees_of_freedom);
  while (1.0 - chi_squared_upper_tail(high, degrees_of_freedom) < probability && high < 1e300) high *= 2.0;
  for (int i = 0; i < 200 && high - low > 1e-14 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (1.0 - chi_squared_upper_tail(middle, degrees_of_freedom) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace soak::base
