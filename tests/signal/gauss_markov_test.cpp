// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/autocorrelation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/random.h"
#include "calib/signal/noise/noise.h"

namespace soak::calib::signal {
namespace {

constexpr double kRate = 10.0;

/// Correlation as a first- or second-order process with white noise on top has it, without any error of estimation.
Autocorrelation exact(double share, double beta_per_s, bool second, std::size_t lags) {
  Autocorrelation acf{.variance = 4.0, .correlation = {1.0}, .samples = 1000000};
  for (std::size_t k = 1; k <= lags; ++k) {
    const double x = beta_per_s * static_cast<double>(k) / kRate;
    acf.correlation.push_back(share * std::exp(-x) * (second ? 1.0 + x : 1.0));
  }
  return acf;
}

TEST(GaussMarkovFit, RecoversAnExactCorrelation) {
  const auto first = fit_gauss_markov_1(exact(0.6, 0.5, false, 300), kRate);
  ASSERT_TRUE(first);
  // a minimum found from the sum of squares alone is sharp to the root of its rounding, 1e-8, and a little more
  EXPECT_NEAR(first->correlation_s, 2.0, 1e-6);
  EXPECT_NEAR(first->beta_per_s, 0.5, 1e-6);
  EXPECT_NEAR(first->sigma, 2.0 * std::sqrt(0.6), 1e-6);
  EXPECT_NEAR(first->white_sigma, 2.0 * std::sqrt(0.4), 1e-6);
  EXPECT_LT(first->rms_misfit, 1e-7);
  const auto second = fit_gauss_markov_2(exact(0.6, 0.5, true, 300), kRate);
  ASSERT_TRUE(second);
  EXPECT_NEAR(second->beta_per_s, 0.5, 1e-6);
  EXPECT_NEAR(second->sigma, 2.0 * std::sqrt(0.6), 1e-6);
}

TEST(GaussMarkovFit, OfSecondOrderStatesTheTimeAtWhichTheCorrelationIsOneOverE) {
  const auto process = fit_gauss_markov_2(exact(1.0, 0.5, true, 300), kRate);
  const double x = process->beta_per_s * process->correlation_s;
  EXPECT_NEAR(std::exp(-x) * (1.0 + x), std::exp(-1.0), 1e-12);
}

TEST(GaussMarkovFit, TellsTheOrdersApartByTheirMisfit) {
  EXPECT_LT(fit_gauss_markov_1(exact(1.0, 0.5, false, 300), kRate)->rms_misfit, 1e-6);
  EXPECT_GT(fit_gauss_markov_2(exact(1.0, 0.5, false, 300), kRate)->rms_misfit, 0.01);
  EXPECT_GT(fit_gauss_markov_1(exact(1.0, 0.5, true, 300), kRate)->rms_misfit, 0.01);
}

/// Second-order process by its exact step over h: state (x, v) with x' = v, v' = -beta^2 x - 2 beta v + w. The exact
/// transition matrix is exp(-beta h) [[1 + beta h, h], [-beta^2 h, 1 - beta h]]; the driving covariance is what keeps
/// the stationary one, diag(sigma^2, beta^2 sigma^2).
std::vector<double> second_order_noise(std::size_t count, double sigma, double beta_per_s, std::uint64_t seed) {
  base::Random random(seed, 77);
  const double h = 1.0 / kRate, b = beta_per_s, e = std::exp(-b * h);
  const double a11 = e * (1.0 + b * h), a12 = e * h, a21 = -e * b * b * h, a22 = e * (1.0 - b * h);
  const double p1 = sigma * sigma, p2 = b * b * p1;
  const double q11 = p1 - a11 * a11 * p1 - a12 * a12 * p2;
  const double q12 = -a11 * a21 * p1 - a12 * a22 * p2;
  const double q22 = p2 - a21 * a21 * p1 - a22 * a22 * p2;
  const double l11 = std::sqrt(q11), l21 = q12 / l11, l22 = std::sqrt(q22 - l21 * l21);
  double x = sigma * random.gaussian();
  double v = b * sigma * random.gaussian();
  std::vector<double> samples(count);
  for (double& sample : samples) {
    sample = x;
    const double w1 = random.gaussian(), w2 = random.gaussian();
    const double next = a11 * x + a12 * v + l11 * w1;
    v = a21 * x + a22 * v + l21 * w1 + l22 * w2;
    x = next;
  }
  return samples;
}

struct Errors {
  double mean = 0.0;
  double rms = 0.0;
};

/// Relative errors of the correlation time over 40 seeds. `fit` gives the fitted time over the true one.
template <class Fit>
Errors errors_of(const Fit& fit) {
  Errors errors;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const double error = fit(seed) - 1.0;
    errors.mean += error / 40.0;
    errors.rms += error * error / 40.0;
  }
  errors.rms = std::sqrt(errors.rms);
  return errors;
}

/// The header states a standard deviation of 1.5 sqrt(2 T/L). The scatter over 40 seeds, uncertain by
/// 1/sqrt(80) = 11 % itself, must not exceed it by three of those, nor the mean be off by more than five standard
/// deviations of a mean, 5/sqrt(40) = 0.8 of it.
void expect_stated_errors(const Errors& errors, double correlation_s, double length_s) {
  const double stated = 1.5 * std::sqrt(2.0 * correlation_s / length_s);
  EXPECT_LT(errors.rms, 1.35 * stated);
  EXPECT_LT(std::abs(errors.mean), 0.8 * stated);
}

constexpr std::size_t kCount = 40000;
constexpr double kLength = static_cast<double>(kCount) / kRate;

TEST(GaussMarkovFit, RecoversAFirstOrderProcess) {
  const Errors errors = errors_of([](std::uint64_t seed) {
    const auto acf = autocorrelation(gauss_markov_noise(kCount, 0.3, 2.0, {kRate, seed}), 200);
    return fit_gauss_markov_1(*acf, kRate)->correlation_s / 2.0;
  });
  expect_stated_errors(errors, 2.0, kLength);
}

TEST(GaussMarkovFit, RecoversASecondOrderProcess) {
  const Errors errors = errors_of([](std::uint64_t seed) {
    const auto acf = autocorrelation(second_order_noise(kCount, 0.3, 1.0, seed), 200);
    return fit_gauss_markov_2(*acf, kRate)->beta_per_s;
  });
  expect_stated_errors(errors, 2.146, kLength);
}

TEST(GaussMarkovFit, IsNotSpoiltByWhiteNoiseOnTop) {
  // White noise of the same variance per sample: its share in the error of the correlation, 1/sqrt(n) per lag, is
  // small beside the process' own, sqrt(2 T/L). The two standard deviations have half the scatter of the time.
  double sigma = 0.0, white_sigma = 0.0;
  const Errors errors = errors_of([&](std::uint64_t seed) {
    std::vector<double> samples = gauss_markov_noise(kCount, 0.3, 2.0, {kRate, seed});
    const std::vector<double> white = white_noise(kCount, 0.3 / std::sqrt(kRate), {kRate, seed});
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i] += white[i];
    const auto process = fit_gauss_markov_1(*autocorrelation(samples, 200), kRate);
    sigma += process->sigma / 40.0;
    white_sigma += process->white_sigma / 40.0;
    return process->correlation_s / 2.0;
  });
  expect_stated_errors(errors, 2.0, kLength);
  EXPECT_NEAR(sigma / 0.3, 1.0, 0.4 * std::sqrt(2.0 * 2.0 / kLength));
  EXPECT_NEAR(white_sigma / 0.3, 1.0, 0.4 * std::sqrt(2.0 * 2.0 / kLength));
}

TEST(GaussMarkovFit, RefusesWhiteNoiseAndLagsThatDoNotSuffice) {
  const auto white = autocorrelation(white_noise(5000, 1.0, {kRate, 3}), 100);
  EXPECT_FALSE(fit_gauss_markov_1(*white, kRate));
  EXPECT_FALSE(fit_gauss_markov_2(*white, kRate));
  EXPECT_FALSE(fit_gauss_markov_1(exact(1.0, 0.5, false, 2), kRate));
  EXPECT_FALSE(fit_gauss_markov_1(exact(1.0, 1e-4, false, 20), kRate));
  EXPECT_FALSE(fit_gauss_markov_1(exact(1.0, 0.5, false, 300), 0.0));
  Autocorrelation gaps = exact(1.0, 5.0, false, 300);
  gaps.correlation[2] = std::nan("");
  EXPECT_FALSE(fit_gauss_markov_1(gaps, kRate));
}

}  // namespace
}  // namespace soak::calib::signal
