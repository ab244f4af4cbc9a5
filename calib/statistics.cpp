// SPDX-License-Identifier: Apache-2.0
#include "calib/statistics.h"

#include <algorithm>
#include <cmath>
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

}  // namespace

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

}  // namespace soak::calib
