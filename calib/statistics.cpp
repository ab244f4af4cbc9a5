// SPDX-License-Identifier: Apache-2.0
#include "calib/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <vector>

#include "calib/signal/mean_error.h"

namespace soak::calib {
namespace {

/// Sum of f(v) over the values in eight interleaved partial sums, so that one addition need not wait for the last.
template <class Function>
double sum_of(std::span<const double> values, const Function& f) {
  std::array<double, 8> partial{};
  for (std::size_t i = 0; i < values.size(); ++i) partial[i % 8] += f(values[i]);
  return std::accumulate(partial.begin(), partial.end(), 0.0);
}

SensorStatistics describe_present(std::span<const double> samples) {
  SensorStatistics result;
  result.count = samples.size();
  if (samples.empty()) return result;
  const double n = static_cast<double>(samples.size());
  // Two passes about a first value: readings near 9.8 with a spread of 1e-3 keep their digits.
  const double origin = samples.front();
  result.mean = origin + sum_of(samples, [&](double v) { return v - origin; }) / n;
  if (samples.size() < 2) return result;
  result.variance = sum_of(samples, [&](double v) { return (v - result.mean) * (v - result.mean); }) / (n - 1.0);
  result.standard_error = signal::standard_error_of_mean(samples).standard_error;
  return result;
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
  const auto is_missing = [](double v) { return std::isnan(v); };
  if (std::none_of(samples.begin(), samples.end(), is_missing)) return describe_present(samples);
  std::vector<double> present;
  present.reserve(samples.size());
  std::remove_copy_if(samples.begin(), samples.end(), std::back_inserter(present), is_missing);
  return describe_present(present);
}

}  // namespace soak::calib
