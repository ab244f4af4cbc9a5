// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "base/statistics.h"
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

constexpr std::size_t kFewestForSpikes = 12;
constexpr double kMostSpikes = 0.01;  ///< of the samples; more are no accident
constexpr double kSigmaPerMad = 1.4826;
/// At an end nobody knows what follows: it may be a movement that begins. A body does not move so fast.
constexpr double kAtAnEnd = 10.0;
/// Of the limit: who touches the unit shakes the neighbours too.
constexpr double kQuietAround = 0.25;
/// No spike is nearer than this to the mean in standard deviations that it has inflated itself: with as many of them as
/// there may be, A/s = 20/sqrt(1 + 0.01*20^2) = 8.9.
constexpr double kNoSpikeWithin = 8.0;

/// A spike beyond 20 sigma among few samples inflates s the most: A/s = 20/sqrt(1 + 400/n), 3.4 for 12.
bool may_hold_spikes(std::span<const double> samples, const SensorStatistics& all) {
  const double n = static_cast<double>(samples.size());
  const double nearest = std::min(kNoSpikeWithin, kSpikeSigmas / std::sqrt(1.0 + kSpikeSigmas * kSpikeSigmas / n));
  // With n samples nothing is farther than sqrt(n) standard deviations away.
  return !(deviation_from(samples, all.mean).peak <= 0.9 * nearest * std::sqrt(all.variance));
}

double robust_deviation(std::span<const double> values, double step) {
  const std::vector<double> shown = thinned(values, kStepSamples);
  const double middle = base::median(shown);
  std::vector<double> sizes;
  for (const double value : shown) sizes.push_back(std::abs(value - middle));
  std::vector<double> changes;
  for (std::size_t i = 1; i < values.size(); ++i) changes.push_back(std::abs(values[i] - values[i - 1]));
  return std::max(
      {kSigmaPerMad * base::median(sizes), kSigmaPerMad * base::median(changes) / std::numbers::sqrt2, step});
}

/// Whether value `i` is off the median of its nearest neighbours (two on each side, as far as there are), and those
/// are quiet.
bool stands_alone(std::span<const double> values, std::size_t i, double limit) {
  const std::size_t first = std::min(i < 2 ? 0 : i - 2, values.size() - 5);
  std::vector<double> around;
  for (std::size_t k = first; k < first + 5; ++k) {
    if (k != i) around.push_back(values[k]);
  }
  const double middle = base::median(around);
  const bool at_an_end = i == 0 || i + 1 == values.size();
  if (!(std::abs(values[i] - middle) > (at_an_end ? kAtAnEnd * limit : limit))) return false;
  return std::ranges::all_of(around, [&](double v) { return std::abs(v - middle) <= kQuietAround * limit; });
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

std::vector<std::size_t> find_spikes(std::span<const double> samples, double step) {
  std::vector<std::size_t> present;
  std::vector<double> values;
  std::vector<std::size_t> spikes;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::isinf(samples[i])) spikes.push_back(i);
    if (!std::isfinite(samples[i])) continue;
    present.push_back(i);
    values.push_back(samples[i]);
  }
  if (values.size() < kFewestForSpikes) return {};
  const double limit = kSpikeSigmas * robust_deviation(values, step);
  if (!(limit > 0.0)) return {};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (stands_alone(values, i, limit)) spikes.push_back(present[i]);
  }
  if (static_cast<double>(spikes.size()) > kMostSpikes * static_cast<double>(samples.size())) return {};
  std::ranges::sort(spikes);
  return spikes;
}

SensorStatistics describe(std::span<const double> samples, double step) {
  if (samples.empty()) return {};
  // One NaN makes the sum NaN. Infinities may too, and then nothing is left out.
  const double sum = sum_above(samples, samples.front());
  if (!std::isnan(sum)) {
    const SensorStatistics all = describe_present(samples, sum, step);
    if (!may_hold_spikes(samples, all)) return all;
  }
  std::vector<double> present(samples.begin(), samples.end());
  for (const std::size_t spike : find_spikes(samples, step)) present[spike] = std::numeric_limits<double>::quiet_NaN();
  std::erase_if(present, [](double v) { return std::isnan(v); });
  return present.empty() ? SensorStatistics{} : describe_present(present, sum_above(present, present.front()), step);
}

}  // namespace soak::calib
