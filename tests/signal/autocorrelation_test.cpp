// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/autocorrelation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "calib/signal/noise/noise.h"

namespace soak::calib::signal {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// By the definition, product by product.
std::vector<double> plain_covariance(const std::vector<double>& samples, std::size_t longest) {
  double sum = 0.0, count = 0.0;
  for (const double v : samples) {
    if (!std::isnan(v)) sum += v, count += 1.0;
  }
  std::vector<double> covariance;
  const auto n = static_cast<double>(samples.size());
  for (std::size_t k = 0; k <= longest; ++k) {
    double products = 0.0, pairs = 0.0;
    for (std::size_t i = 0; i + k < samples.size(); ++i) {
      const double product = (samples[i] - sum / count) * (samples[i + k] - sum / count);
      if (!std::isnan(product)) products += product, pairs += 1.0;
    }
    covariance.push_back(products / pairs * (1.0 - static_cast<double>(k) / n));
  }
  return covariance;
}

void expect_equal_to_plain(const std::vector<double>& samples, std::size_t longest) {
  const auto acf = autocorrelation(samples, longest);
  ASSERT_TRUE(acf);
  const std::vector<double> expected = plain_covariance(samples, longest);
  EXPECT_NEAR(acf->variance, expected[0], 1e-12 * expected[0]);
  ASSERT_EQ(acf->correlation.size(), longest + 1);
  // 1e-12: transforms of 2^14 points round by some 1e-15
  for (std::size_t k = 0; k <= longest; ++k) EXPECT_NEAR(acf->correlation[k], expected[k] / expected[0], 1e-12) << k;
}

TEST(Autocorrelation, EqualsTheSumOfProducts) {
  expect_equal_to_plain(gauss_markov_noise(50, 1.0, 4.0, {1.0, 1}), 49);
  expect_equal_to_plain(gauss_markov_noise(20000, 1.0, 4.0, {1.0, 1}), 30);    // several blocks
  expect_equal_to_plain(gauss_markov_noise(30000, 1.0, 40.0, {1.0, 1}), 300);  // a block that ends within the lags
  expect_equal_to_plain(gauss_markov_noise(7900, 1.0, 4.0, {1.0, 1}), 3000);   // lags longer than a quarter block
}

TEST(Autocorrelation, LeavesOutMissingSamples) {
  std::vector<double> samples = gauss_markov_noise(9000, 2.0, 5.0, {1.0, 3});
  for (std::size_t i = 0; i < samples.size(); i += 7) samples[i] = kNaN;
  for (std::size_t i = 4000; i < 4200; ++i) samples[i] = kNaN;
  expect_equal_to_plain(samples, 100);
}

TEST(Autocorrelation, KeepsItsDigitsOnALargeMean) {
  std::vector<double> samples = gauss_markov_noise(1000, 1.0, 5.0, {1.0, 3});
  const auto expected = autocorrelation(samples, 20);
  for (double& v : samples) v += 1e6;
  const auto acf = autocorrelation(samples, 20);
  for (std::size_t k = 0; k <= 20; ++k) EXPECT_NEAR(acf->correlation[k], expected->correlation[k], 1e-8);
}

TEST(Autocorrelation, IsUnknownWhereNoTwoSamplesAreThatFarApart) {
  std::vector<double> samples = white_noise(100, 1.0, {1.0, 3});
  for (std::size_t i = 0; i < samples.size(); i += 2) samples[i] = kNaN;
  const auto acf = autocorrelation(samples, 4);
  EXPECT_EQ(acf->samples, 50U);
  EXPECT_TRUE(std::isnan(acf->correlation[1]));
  EXPECT_FALSE(std::isnan(acf->correlation[2]));
}

TEST(Autocorrelation, RefusesWhatHasNone) {
  const std::vector<double> samples = white_noise(100, 1.0, {1.0, 3});
  EXPECT_FALSE(autocorrelation(samples, 0));
  EXPECT_FALSE(autocorrelation(samples, 100));
  EXPECT_TRUE(autocorrelation(samples, 99));
  EXPECT_FALSE(autocorrelation(std::vector<double>(100, 0.1), 5));
  std::vector<double> few(100, kNaN);
  for (std::size_t i = 0; i < 7; ++i) few[i] = static_cast<double>(i);
  EXPECT_FALSE(autocorrelation(few, 5));
  std::vector<double> infinite = samples;
  infinite[42] = -std::numeric_limits<double>::infinity();
  const auto refused = autocorrelation(infinite, 5);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "sample 42");
}

TEST(CorrelationTime, IsWhereTheCorrelationFallsToOneOverE) {
  Autocorrelation acf;
  acf.correlation = {1.0, 0.5, 0.25};
  // straight between 0.5 at 1 and 0.25 at 2
  EXPECT_NEAR(correlation_time_s(acf, 10.0), (1.0 + (0.5 - std::exp(-1.0)) / 0.25) / 10.0, 1e-15);
  acf.correlation = {1.0, 0.9, 0.8};
  EXPECT_TRUE(std::isnan(correlation_time_s(acf, 10.0)));
  acf.correlation = {1.0, kNaN, 0.2};
  EXPECT_TRUE(std::isnan(correlation_time_s(acf, 10.0)));
}

TEST(CorrelationTime, OfASimulatedProcessIsItsOwn) {
  // 1e6 samples at T = 50: relative standard deviation of the correlation time about sqrt(2*50/1e6) = 1 %; four of
  // them.
  const auto acf = autocorrelation(gauss_markov_noise(1000000, 1.0, 5.0, {10.0, 4}), 200);
  EXPECT_NEAR(correlation_time_s(*acf, 10.0), 5.0, 0.2);
}

}  // namespace
}  // namespace soak::calib::signal
