// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/statistics.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "calib/segments/detail/sample_scan.h"
#include "calib/signal/noise/mean_error.h"

namespace soak::calib {
namespace {

constexpr double kFloatStep = 0x1p-23;  ///< of float32 numbers, as a share of the number, at most
constexpr double kRareShare = 0.01;
constexpr double kOffLattice = 0.02;  ///< of a step; numbers are rounded to float32 and converted

/// `sum`: of the samples less the first one.
SensorStatistics describe_present(std::span<const double> samples, double sum, double step) {
  SensorStatistics result;
  result.count = samples.size();
  const double n = static_cast<double>(samples.size());
  // Two passes about a first value: readings near 9.8 with a spread of 1e-3 keep their digits.
  result.mean = samples.front() + sum / n;
  if (samples.size() < 2) return result;
  result.variance = squares_about(samples, result.mean) / (n - 1.0);
  result.standard_error =
      std::hypot(signal::standard_error_of_mean(samples).standard_error,
                 rounding_error(std::max(step, kFloatStep * std::abs(result.mean)), result.variance));
  return result;
}

/// Distances between neighbouring numbers of those that samples show.
std::vector<double> distances_of(std::vector<double> shown) {
  std::sort(shown.begin(), shown.end());
  shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
  std::adjacent_difference(shown.begin(), shown.end(), shown.begin());
  if (!shown.empty()) shown.erase(shown.begin());
  return shown;
}

/// In steps, of samples whose variance is `squares` square steps: with little noise a share p of them lies on the upper
/// one of two codes, p (1 - p) = squares, and the mean is off by up to |p - 1/2| = sqrt(1/4 - squares).
double error_between_two_codes(double squares) { return std::sqrt(std::max(0.0, 0.25 - squares) / 3.0); }

/// In steps, of Gaussian noise: squares = sigma^2 + 1/12 [Sheppard].
double error_of_rounded_gaussian(double squares) {
  constexpr int kTerms = 30;  // the rest of sum 1/k^2 is 2 % of it
  constexpr double kPi2 = std::numbers::pi * std::numbers::pi;
  const double noise = squares - 1.0 / 12.0;
  if (noise <= 0.0) return 1.0 / std::sqrt(12.0);
  double sum = 0.0;
  for (int k = 1; k <= kTerms; ++k) sum += std::exp(-4.0 * kPi2 * k * k * noise) / (k * k);
  return std::sqrt(sum / (2.0 * kPi2));
}

}  // namespace

Line fit_line(std::span<const double> x, std::span<const double> y) {
  Line line;
  if (x.empty()) return line;
  add_quotients(x, y, static_cast<double>(x.size()), line.mean_x, line.mean_y);
  double sxx = 0.0;
  double sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += (x[i] - line.mean_x) * (x[i] - line.mean_x);
    sxy += (x[i] - line.mean_x) * (y[i] - line.mean_y);
  }
  line.slope = sxx > 0.0 ? sxy / sxx : 0.0;
  return line;
}

double output_step(std::span<const double> samples) { return output_step_of(thinned(samples, kStepSamples)); }

double output_step_of(std::vector<double> shown) {
  std::vector<double> distances = distances_of(std::move(shown));
  if (distances.empty()) return 0.0;
  const auto rare = static_cast<std::size_t>(kRareShare * static_cast<double>(distances.size()));
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(rare), distances.end());
  const double step = distances[rare];
  const auto off = std::count_if(distances.begin(), distances.end(), [&](double distance) {
    return std::abs(distance / step - std::round(distance / step)) > kOffLattice;
  });
  return static_cast<std::size_t>(off) <= rare ? step : 0.0;
}

double rounding_error(double step, double variance) {
  if (!(step > 0.0)) return 0.0;
  const double squares = variance / (step * step);
  return step * std::max(error_between_two_codes(squares), error_of_rounded_gaussian(squares));
}

SensorStatistics describe(std::span<const double> samples, double step) {
  if (samples.empty()) return {};
  // One NaN makes the sum NaN. Infinities may too, and then nothing is left out.
  const double sum = sum_above(samples, samples.front());
  if (!std::isnan(sum)) return describe_present(samples, sum, step);
  std::vector<double> present;
  present.reserve(samples.size());
  std::remove_copy_if(samples.begin(), samples.end(), std::back_inserter(present),
                      [](double v) { return std::isnan(v); });
  return present.empty() ? SensorStatistics{} : describe_present(present, sum_above(present, present.front()), step);
}

}  // namespace soak::calib
