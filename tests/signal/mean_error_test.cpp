// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/mean_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "calib/signal/noise.h"

namespace soak::calib::signal {
namespace {

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// What was stated against what happened, over many seeds.
struct Honesty {
  double ratio = 0.0;  ///< root mean square of error/stated error: above 1 where too little is stated
  double size = 0.0;   ///< root mean square error over root mean square stated error
};

constexpr std::uint64_t kSeeds = 200;

/// `simulate` makes a record of a given length; `error_of` tells the error of the mean of its first `count` samples.
template <class Simulate, class ErrorOf>
Honesty honesty(std::size_t count, std::size_t length, const Simulate& simulate, const ErrorOf& error_of) {
  double ratios = 0.0, errors = 0.0, stated = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<double> record = simulate(length, seed);
    const double error = error_of(record);
    const double standard_error = standard_error_of_mean(std::span(record).first(count)).standard_error;
    ratios += std::pow(error / standard_error, 2) / static_cast<double>(kSeeds);
    errors += error * error;
    stated += standard_error * standard_error;
  }
  return {std::sqrt(ratios), std::sqrt(errors / stated)};
}

/// For noise with a true mean of 0.
template <class Simulate>
Honesty honesty_of_mean(std::size_t count, const Simulate& simulate) {
  return honesty(count, count, simulate, [](const std::vector<double>& record) { return mean_of(record); });
}

/// For noise without a mean of its own: the difference of the means of adjacent stretches over sqrt(2).
template <class Simulate>
Honesty honesty_of_next_mean(std::size_t count, const Simulate& simulate) {
  return honesty(count, 2 * count, simulate, [&](const std::vector<double>& record) {
    const std::span<const double> all(record);
    return (mean_of(all.subspan(count)) - mean_of(all.first(count))) / std::sqrt(2.0);
  });
}

// The ratio of 200 seeds has a relative standard deviation of 1/sqrt(2 * 200) = 5 % by itself, and a little more
// because the stated error scatters too.

TEST(MeanError, IsHonestForWhiteNoise) {
  const auto white = [](std::size_t n, std::uint64_t seed) { return white_noise(n, 1.0, {1.0, seed}); };
  for (const std::size_t count : {100U, 1000U, 6000U}) {
    const Honesty h = honesty_of_mean(count, white);
    EXPECT_NEAR(h.ratio, 0.95, 0.15) << count;  // stated a little too large: the larger of two estimates
  }
}

TEST(MeanError, OfWhiteNoiseIsHardlyInflated) {
  // Mean of the stated error over sigma/sqrt(n): what the larger of two estimates and the chance of taking white noise
  // for something worse cost.
  for (const std::size_t count : {1000U, 6000U}) {
    double stated = 0.0;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      stated +=
          standard_error_of_mean(white_noise(count, 1.0, {1.0, seed})).standard_error / static_cast<double>(kSeeds);
    }
    EXPECT_NEAR(stated * std::sqrt(static_cast<double>(count)), 1.05, 0.05) << count;
  }
}

TEST(MeanError, IsHonestForCorrelatedNoiseThatEndsWithinTheStretch) {
  for (const double time : {3.0, 10.0, 30.0}) {
    const auto process = [&](std::size_t n, std::uint64_t seed) {
      return gauss_markov_noise(n, 1.0, time, {1.0, seed});
    };
    const Honesty h = honesty_of_mean(6000, process);
    EXPECT_GT(h.ratio, 0.75) << time;
    EXPECT_LT(h.ratio, 1.2) << time;
  }
}

// Flicker and random walk: the size of what is stated within 0.8 to 1.25 of what happens. The ratio seed by seed is
// harsher on the few records that happen to look like a noise that ends.

TEST(MeanError, IsHonestForFlickerNoise) {
  const auto flicker = [](std::size_t n, std::uint64_t seed) { return flicker_noise(n, 1.0, {1.0, seed}); };
  for (const std::size_t count : {600U, 6000U}) {
    const Honesty h = honesty_of_next_mean(count, flicker);
    EXPECT_GT(h.size, 0.8) << count;
    EXPECT_LT(h.size, 1.25) << count;
    EXPECT_LT(h.ratio, 1.5) << count;
  }
}

TEST(MeanError, IsHonestForARandomWalk) {
  const auto walk = [](std::size_t n, std::uint64_t seed) { return random_walk(n, 1.0, {1.0, seed}); };
  for (const std::size_t count : {600U, 6000U}) {
    const Honesty h = honesty_of_next_mean(count, walk);
    EXPECT_GT(h.size, 0.8) << count;
    EXPECT_LT(h.size, 1.25) << count;
    EXPECT_LT(h.ratio, 1.5) << count;
  }
}

TEST(MeanError, IsNeverBelowEitherOfItsTwoParts) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const MeanError e = standard_error_of_mean(flicker_noise(1000, 1.0, {1.0, seed}));
    EXPECT_EQ(e.standard_error, std::max(e.from_correlation, e.from_allan));
  }
}

TEST(MeanError, CountsEffectiveSamples) {
  const std::vector<double> samples = gauss_markov_noise(20000, 1.0, 10.0, {1.0, 1});
  const MeanError e = standard_error_of_mean(samples);
  double squares = 0.0;
  const double mean = mean_of(samples);
  for (const double v : samples) squares += std::pow(v - mean, 2);
  EXPECT_NEAR(e.effective_samples, squares / 19999.0 / (e.standard_error * e.standard_error), 1e-6);
}

TEST(MeanError, DoesNotTakeAStraightLineForNoise) {
  const std::vector<double> samples = white_noise(5000, 1.0, {1.0, 1});
  std::vector<double> drifting = samples;
  for (std::size_t i = 0; i < drifting.size(); ++i) drifting[i] += 0.01 * static_cast<double>(i);
  // The line comes off exactly; what stays is the rounding of values some 50 times the noise.
  const double expected = standard_error_of_mean(samples).standard_error;
  EXPECT_NEAR(standard_error_of_mean(drifting).standard_error, expected, 1e-10 * expected);
}

TEST(MeanError, ScalesWithTheUnitAndNotWithTheMean) {
  const std::vector<double> samples = flicker_noise(2000, 1.0, {1.0, 1});
  std::vector<double> scaled = samples;
  for (double& v : scaled) v = 1e3 + 1e-3 * v;
  const double expected = 1e-3 * standard_error_of_mean(samples).standard_error;
  EXPECT_NEAR(standard_error_of_mean(scaled).standard_error, expected, 1e-9 * expected);
}

TEST(MeanError, OfWhatDoesNotVaryIsZero) {
  for (const std::size_t count : {0U, 1U, 2U, 5U, 40U, 1000U}) {
    const MeanError e = standard_error_of_mean(std::vector<double>(count, 0.1));
    EXPECT_EQ(e.standard_error, 0.0) << count;
    EXPECT_EQ(e.effective_samples, 0.0) << count;
  }
}

TEST(MeanError, OfTwoSamplesIsTheirStandardErrorOverOneDegreeOfFreedom) {
  EXPECT_DOUBLE_EQ(standard_error_of_mean(std::vector<double>{1.0, 3.0}).standard_error, 1.0);
}

}  // namespace
}  // namespace soak::calib::signal
