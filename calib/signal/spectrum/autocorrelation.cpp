// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/autocorrelation.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <span>

#include "calib/signal/samples/sample_grid.h"
#include "calib/signal/spectrum/detail/fourier.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kFewestSamples = 8;
constexpr std::size_t kShortestTransform = 8192;

base::Status check_lags(std::span<const double> samples, std::size_t longest) {
  if (auto status = check_none_infinite(samples); !status) return status;
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

constexpr std::size_t kFewestLags = 3;
/// Lags beyond are mostly error of estimation. Measured on simulated processes: a tenth instead makes the scatter of
/// the time a third larger, a half makes white noise on top tell more.
constexpr double kEndOfCorrelation = 0.3;

/// Root of exp(-x)(1 + x) = 1/e.
constexpr double kSecondOrderTime = 2.1461932206205825;

/// Correlation of a process at x = beta t.
using CorrelationShape = double (*)(double x);
double first_order(double x) { return std::exp(-x); }
double second_order(double x) { return std::exp(-x) * (1.0 + x); }

base::Status check_correlation(const Autocorrelation& acf, double rate_hz) {
  if (auto status = check_rate(rate_hz); !status) return status;
  if (acf.correlation.size() < kFewestLags + 1) {
    return base::bad_input(
        fmt::format("{} lags; a Gauss-Markov process needs 0 to {}", acf.correlation.size(), kFewestLags));
  }
  const double least = 4.0 / std::sqrt(static_cast<double>(acf.samples));
  if (!(acf.correlation[1] >= least)) {
    return base::bad_input(
        fmt::format("the correlation is {:.3g} after one sample, that of white noise (below {:.3g}): there is no "
                    "Gauss-Markov process to fit",
                    acf.correlation[1], least));
  }
  return {};
}

/// Correlation at the lags to fit: 1, 2, ..
std::span<const double> fitted_lags(const Autocorrelation& acf) {
  const std::span<const double> from_one = std::span(acf.correlation).subspan(1);
  const double end = kEndOfCorrelation * from_one.front();
  const auto below = std::find_if(from_one.begin(), from_one.end(), [&](double rho) { return !(rho >= end); });
  const auto count = static_cast<std::size_t>(below - from_one.begin());
  return from_one.first(std::max(count, kFewestLags));
}

/// How well a rho(k step) fits, with the best a of 0..1.
struct AmplitudeFit {
  double amplitude = 0.0;
  double misfit = 0.0;  ///< sum of squares
};

AmplitudeFit fit_amplitude(std::span<const double> correlation, CorrelationShape shape, double step) {
  double products = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < correlation.size(); ++i) {
    const double rho = shape(static_cast<double>(i + 1) * step);
    products += rho * correlation[i];
    squares += rho * rho;
  }
  AmplitudeFit fit{std::clamp(products / squares, 0.0, 1.0), 0.0};
  for (std::size_t i = 0; i < correlation.size(); ++i) {
    fit.misfit += std::pow(correlation[i] - fit.amplitude * shape(static_cast<double>(i + 1) * step), 2);
  }
  return fit;
}

/// Least value of a function of one variable between two bounds by golden sections; its least value on a grid tells
/// which of several valleys is the deepest.
template <class Function>
double minimise(double low, double high, const Function& f) {
  constexpr int kGrid = 60;
  const double spacing = (high - low) / kGrid;
  double best = low;
  for (int i = 1; i <= kGrid; ++i) {
    if (f(low + i * spacing) < f(best)) best = low + i * spacing;
  }
  double a = best - spacing;
  double b = best + spacing;
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  while (b - a > 1e-10) {
    const double left = b - golden * (b - a);
    const double right = a + golden * (b - a);
    if (f(left) < f(right)) {
      b = right;
    } else {
      a = left;
    }
  }
  return 0.5 * (a + b);
}

base::Result<GaussMarkov> fit_shape(const Autocorrelation& acf, double rate_hz, CorrelationShape shape,
                                    double time_times_beta) {
  if (auto status = check_correlation(acf, rate_hz); !status) return base::forward_error(status);
  const std::span<const double> correlation = fitted_lags(acf);
  if (std::any_of(correlation.begin(), correlation.end(), [](double rho) { return std::isnan(rho); })) {
    return base::bad_input("too many samples are missing: some of the first lags have no pair");
  }
  // beta per sample: from a correlation that hardly falls within the lags to one that is gone after the first
  const double slowest = std::log(0.1 / static_cast<double>(correlation.size()));
  const double best = minimise(slowest, std::log(10.0),
                               [&](double ln) { return fit_amplitude(correlation, shape, std::exp(ln)).misfit; });
  if (best < slowest + 0.1) {
    return base::bad_input(fmt::format("the correlation does not fall within {} lags; longer lags would show it",
                                       acf.correlation.size() - 1));
  }
  const double beta = std::exp(best);
  const AmplitudeFit fitted = fit_amplitude(correlation, shape, beta);
  return GaussMarkov{.sigma = std::sqrt(fitted.amplitude * acf.variance),
                     .correlation_s = time_times_beta / (beta * rate_hz),
                     .beta_per_s = beta * rate_hz,
                     .white_sigma = std::sqrt((1.0 - fitted.amplitude) * acf.variance),
                     .rms_misfit = std::sqrt(fitted.misfit / static_cast<double>(correlation.size()))};
}

}  // namespace

base::Result<Autocorrelation> autocorrelation(std::span<const double> samples, std::size_t longest) {
  if (auto status = check_lags(samples, longest); !status) return base::forward_error(status);
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

base::Result<GaussMarkov> fit_gauss_markov_1(const Autocorrelation& acf, double rate_hz) {
  return fit_shape(acf, rate_hz, first_order, 1.0);
}

base::Result<GaussMarkov> fit_gauss_markov_2(const Autocorrelation& acf, double rate_hz) {
  return fit_shape(acf, rate_hz, second_order, kSecondOrderTime);
}

}  // namespace soak::calib::signal
