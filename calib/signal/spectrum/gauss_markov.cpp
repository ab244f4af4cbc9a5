// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/gauss_markov.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace soak::calib::signal {
namespace {

constexpr std::size_t kFewestLags = 3;
/// Lags beyond are mostly error of estimation. Measured on simulated processes: a tenth instead makes the scatter of
/// the time a third larger, a half makes white noise on top tell more.
constexpr double kEndOfCorrelation = 0.3;

/// Root of exp(-x)(1 + x) = 1/e.
constexpr double kSecondOrderTime = 2.1461932206205825;

/// Correlation of a process at x = beta t.
using Shape = double (*)(double x);
double first_order(double x) { return std::exp(-x); }
double second_order(double x) { return std::exp(-x) * (1.0 + x); }

base::Status check(const Autocorrelation& acf, double rate_hz) {
  if (!std::isfinite(rate_hz) || rate_hz <= 0.0) {
    return base::bad_input(fmt::format("the rate is {} Hz; a Gauss-Markov process needs a positive one", rate_hz));
  }
  if (acf.correlation.size() < kFewestLags + 1) {
    return base::bad_input(
        fmt::format("{} lags; a Gauss-Markov process needs 0 to {}", acf.correlation.size(), kFewestLags));
  }
  const double least = 4.0 / std::sqrt(static_cast<double>(acf.samples));
  if (!(acf.correlation[1] >= least)) {
    return base::bad_input(
        fmt::format("the correlation is {:.3g} after one sample, that of white noise (below {:.3g}): "
                    "there is no Gauss-Markov process to fit",
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
struct Fit {
  double amplitude = 0.0;
  double misfit = 0.0;  ///< sum of squares
};

Fit fit_amplitude(std::span<const double> correlation, Shape shape, double step) {
  double products = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < correlation.size(); ++i) {
    const double rho = shape(static_cast<double>(i + 1) * step);
    products += rho * correlation[i];
    squares += rho * rho;
  }
  Fit fit{std::clamp(products / squares, 0.0, 1.0), 0.0};
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

base::Result<GaussMarkov> fit(const Autocorrelation& acf, double rate_hz, Shape shape, double time_times_beta) {
  if (auto status = check(acf, rate_hz); !status) return base::forward_error(status);
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
  const Fit fitted = fit_amplitude(correlation, shape, beta);
  return GaussMarkov{.sigma = std::sqrt(fitted.amplitude * acf.variance),
                     .correlation_s = time_times_beta / (beta * rate_hz),
                     .beta_per_s = beta * rate_hz,
                     .white_sigma = std::sqrt((1.0 - fitted.amplitude) * acf.variance),
                     .rms_misfit = std::sqrt(fitted.misfit / static_cast<double>(correlation.size()))};
}

}  // namespace

base::Result<GaussMarkov> fit_gauss_markov_1(const Autocorrelation& acf, double rate_hz) {
  return fit(acf, rate_hz, first_order, 1.0);
}

base::Result<GaussMarkov> fit_gauss_markov_2(const Autocorrelation& acf, double rate_hz) {
  return fit(acf, rate_hz, second_order, kSecondOrderTime);
}

}  // namespace soak::calib::signal
