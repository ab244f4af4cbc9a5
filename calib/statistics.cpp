// SPDX-License-Identifier: Apache-2.0
#include "calib/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace soak::calib {
namespace {

constexpr std::size_t kMaxGroups = 512;

/// Means of consecutive groups of `size` samples; a rest shorter than a group is left out.
std::vector<double> group_means(const std::vector<double>& samples, std::size_t size) {
  std::vector<double> means;
  means.reserve(samples.size() / size);
  for (std::size_t first = 0; first + size <= samples.size(); first += size) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + size; ++i) sum += samples[i];
    means.push_back(sum / static_cast<double>(size));
  }
  return means;
}

void remove_line(std::vector<double>& values) {
  std::vector<double> index(values.size());
  for (std::size_t i = 0; i < index.size(); ++i) index[i] = static_cast<double>(i);
  const Line line = fit_line(index, values);
  for (std::size_t i = 0; i < index.size(); ++i) values[i] -= line.mean_y + line.slope * (index[i] - line.mean_x);
}

/// Factor by which correlation raises the variance of the mean of `z` (mean removed) over that of white noise.
double variance_inflation(const std::vector<double>& z) {
  const std::size_t n = z.size();
  double c0 = 0.0;
  for (const double v : z) c0 += v * v;
  if (n < 8 || c0 <= 0.0) return 1.0;
  const auto correlation = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < n; ++i) sum += z[i] * z[i + lag];
    return sum / c0;
  };
  double inflation = 1.0;
  for (std::size_t lag = 1; lag + 1 < n / 2; lag += 2) {
    const double odd = correlation(lag);
    const double even = correlation(lag + 1);
    if (odd + even <= 0.0) break;
    const double nn = static_cast<double>(n);
    inflation += 2.0 * (odd * (1.0 - static_cast<double>(lag) / nn) + even * (1.0 - static_cast<double>(lag + 1) / nn));
  }
  return std::max(1.0, inflation);
}

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
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const std::size_t half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

Line fit_line(std::span<const double> x, std::span<const double> y) {
  Line line;
  if (x.empty()) return line;
  const double n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    line.mean_x += x[i] / n;
    line.mean_y += y[i] / n;
  }
  double sxx = 0.0;
  double sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += (x[i] - line.mean_x) * (x[i] - line.mean_x);
    sxy += (x[i] - line.mean_x) * (y[i] - line.mean_y);
  }
  line.slope = sxx > 0.0 ? sxy / sxx : 0.0;
  return line;
}

SensorStatistics describe(std::span<const double> samples) {
  std::vector<double> present;
  present.reserve(samples.size());
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(present), [](double v) { return !std::isnan(v); });
  SensorStatistics result;
  result.count = present.size();
  if (present.empty()) return result;
  const double n = static_cast<double>(present.size());
  // Two passes about a first value: readings near 9.8 with a spread of 1e-3 keep their digits.
  const double origin = present.front();
  double sum = 0.0;
  for (const double v : present) sum += v - origin;
  result.mean = origin + sum / n;
  double squares = 0.0;
  for (const double v : present) squares += (v - result.mean) * (v - result.mean);
  if (present.size() < 2) return result;
  result.variance = squares / (n - 1.0);

  std::vector<double> groups = group_means(present, (present.size() + kMaxGroups - 1) / kMaxGroups);
  remove_line(groups);
  double group_squares = 0.0;
  for (const double v : groups) group_squares += v * v;
  const double m = static_cast<double>(groups.size());
  const double group_variance = m > 2.0 ? group_squares / (m - 2.0) : result.variance;
  result.standard_error = std::sqrt(group_variance / m * variance_inflation(groups));
  return result;
}

double student_t_two_sided(double probability, double degrees_of_freedom) {
  const auto inside = [&](double t) {
    return 1.0 - incomplete_beta(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t));
  };
  double low = 0.0;
  double high = 1.0;
  while (inside(high) < probability && high < 1e12) high *= 2.0;
  for (int i = 0; i < 200 && high - low > 1e-14 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (inside(middle) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
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

}  // namespace soak::calib
