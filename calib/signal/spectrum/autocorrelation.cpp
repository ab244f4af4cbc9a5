// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/autocorrelation.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "calib/signal/spectrum/detail/fourier.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kFewestSamples = 8;
constexpr std::size_t kShortestTransform = 8192;

base::Status check(std::span<const double> samples, std::size_t longest) {
  const auto infinite = std::find_if(samples.begin(), samples.end(), [](double v) { return std::isinf(v); });
  if (infinite != samples.end()) {
    return base::bad_input("the sample is infinite; one that is missing must be NaN",
                           fmt::format("sample {}", infinite - samples.begin()));
  }
  const auto present = std::count_if(samples.begin(), samples.end(), [](double v) { return !std::isnan(v); });
  if (present < static_cast<std::ptrdiff_t>(kFewestSamples)) {
    return base::bad_input(
        fmt::format("{} samples are present; a correlation needs at least {}", present, kFewestSamples));
  }
  if (longest == 0 || longest >= samples.size()) {
    return base::bad_input(
        fmt::format("the longest lag is {} samples; it must be at least 1 and below the {} of the signal", longest,
                    samples.size()));
  }
  return {};
}

/// sum_i x_i x_(i+k), k = 0..longest. Blocks of B samples, each against itself and the `longest` samples after it:
/// transforms of P = B + longest points have no wrapped products at these lags.
std::vector<double> lagged_products(const std::vector<double>& x, std::size_t longest) {
  const std::size_t points = std::max(kShortestTransform, std::bit_ceil(4 * longest));
  const std::size_t block = points - longest;
  RealFourier fourier(points);
  std::vector<std::complex<double>> sum(points / 2 + 1);
  std::vector<double> piece(points);
  for (std::size_t first = 0; first < x.size(); first += block) {
    const auto copy = [&](std::size_t count) {
      std::fill(piece.begin(), piece.end(), 0.0);
      std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(first), std::min(count, x.size() - first), piece.begin());
      const auto transform = fourier.forward(piece);
      return std::vector<std::complex<double>>(transform.begin(), transform.end());
    };
    const std::vector<std::complex<double>> left = copy(block);
    const std::vector<std::complex<double>> right = copy(points);
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += std::conj(left[k]) * right[k];
  }
  std::vector<double> products = inverse_fourier(sum);
  products.resize(longest + 1);
  return products;
}

/// Signal less the mean of its samples, 0 where one is missing.
std::vector<double> centred(std::span<const double> samples, const std::vector<double>& present, double count) {
  const double origin = *std::find_if(samples.begin(), samples.end(), [](double v) { return !std::isnan(v); });
  double sum = 0.0;
  for (const double v : samples) sum += std::isnan(v) ? 0.0 : v - origin;
  std::vector<double> x(samples.size(), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (present[i] > 0.0) x[i] = samples[i] - origin - sum / count;
  }
  return x;
}

/// How many pairs of samples are k = 0..longest apart.
std::vector<double> pairs_apart(const std::vector<double>& present, std::size_t samples, std::size_t longest) {
  std::vector<double> pairs(longest + 1);
  if (samples == present.size()) {
    for (std::size_t k = 0; k <= longest; ++k) pairs[k] = static_cast<double>(samples - k);
    return pairs;
  }
  pairs = lagged_products(present, longest);
  for (double& count : pairs) count = std::round(count);
  return pairs;
}

}  // namespace

base::Result<Autocorrelation> autocorrelation(std::span<const double> samples, std::size_t longest) {
  if (auto status = check(samples, longest); !status) return base::forward_error(status);
  std::vector<double> present(samples.size());
  std::transform(samples.begin(), samples.end(), present.begin(), [](double v) { return std::isnan(v) ? 0.0 : 1.0; });
  Autocorrelation acf;
  acf.samples = static_cast<std::size_t>(std::count(present.begin(), present.end(), 1.0));
  const std::vector<double> x = centred(samples, present, static_cast<double>(acf.samples));
  if (std::all_of(x.begin(), x.end(), [](double v) { return v == 0.0; })) {
    return base::bad_input("the signal does not vary; it has no correlation");
  }
  const std::vector<double> products = lagged_products(x, longest);
  const std::vector<double> pairs = pairs_apart(present, acf.samples, longest);
  acf.variance = products[0] / pairs[0];
  acf.correlation.assign(longest + 1, std::numeric_limits<double>::quiet_NaN());
  const auto n = static_cast<double>(samples.size());
  for (std::size_t k = 0; k <= longest; ++k) {
    if (pairs[k] > 0.0) {
      acf.correlation[k] = products[k] / pairs[k] * (1.0 - static_cast<double>(k) / n) / acf.variance;
    }
  }
  return acf;
}

double correlation_time_s(const Autocorrelation& acf, double rate_hz) {
  const double target = 1.0 / std::numbers::e;
  for (std::size_t k = 1; k < acf.correlation.size(); ++k) {
    const double before = acf.correlation[k - 1];
    const double after = acf.correlation[k];
    if (after > target) continue;
    return (static_cast<double>(k - 1) + (before - target) / (before - after)) / rate_hz;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace soak::calib::signal
