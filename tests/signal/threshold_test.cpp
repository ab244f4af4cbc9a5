// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/denoising.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/random.h"

namespace soak::calib::signal {
namespace {

constexpr std::array kShrinkages = {Shrinkage::soft, Shrinkage::hard, Shrinkage::garrote};

double shrunk(double d, double threshold, Shrinkage rule) {
  shrink({&d, 1}, threshold, rule);
  return d;
}

std::vector<double> shrunk(std::vector<double> d, double threshold, Shrinkage rule) {
  shrink(d, threshold, rule);
  return d;
}

std::vector<double> gaussian(std::size_t count, std::uint64_t seed) {
  base::Random random(seed);
  std::vector<double> values(count);
  for (double& v : values) v = random.gaussian();
  return values;
}

/// The rules as they are printed.
double printed(double d, double threshold, Shrinkage rule) {
  if (std::abs(d) <= threshold) return 0.0;
  if (rule == Shrinkage::soft) return std::copysign(std::abs(d) - threshold, d);
  return rule == Shrinkage::hard ? d : d - threshold * threshold / d;
}

TEST(Shrink, KeepsWhatTheRuleSays) {
  const std::vector<double> d = {-5, -2, -1, 0, 1, 2, 2.5, 4};
  EXPECT_EQ(shrunk(d, 2.0, Shrinkage::soft), (std::vector<double>{-3, 0, 0, 0, 0, 0, 0.5, 2}));
  EXPECT_EQ(shrunk(d, 2.0, Shrinkage::hard), (std::vector<double>{-5, 0, 0, 0, 0, 0, 2.5, 4}));
  EXPECT_EQ(shrunk(d, 2.0, Shrinkage::none), d);
  // d - 4/d
  const std::vector<double> garrote = shrunk(d, 2.0, Shrinkage::garrote);
  const std::vector<double> expected = {-4.2, 0, 0, 0, 0, 0, 0.9, 3};
  for (std::size_t i = 0; i < d.size(); ++i) EXPECT_DOUBLE_EQ(garrote[i], expected[i]) << d[i];
}

TEST(Shrink, IsTheSameForEveryLengthAndPlace) {
  // Soft and hard to the last bit: this file is compiled for any processor, shrink() for this one.
  for (std::size_t count = 0; count < 60; ++count) {
    const std::vector<double> d = gaussian(count, count);
    for (const Shrinkage rule : kShrinkages) {
      const std::vector<double> kept = shrunk(d, 0.8, rule);
      for (std::size_t i = 0; i < count; ++i) {
        EXPECT_EQ(kept[i], shrunk(d[i], 0.8, rule));
        // Garrote: d - d q^2 rounds four times, relative to |d| < 5 each.
        EXPECT_NEAR(kept[i], printed(d[i], 0.8, rule), rule == Shrinkage::garrote ? 3e-15 : 0.0);
      }
    }
  }
}

TEST(Shrink, SoftAndGarroteAreContinuousAndHardIsNot) {
  const double threshold = 3.0;
  const double step = 1e-9;
  for (const double side : {-1.0, 1.0}) {
    const double above = side * threshold * (1.0 + step);
    // Slopes at the threshold: 1 and 2.
    EXPECT_NEAR(std::abs(shrunk(above, threshold, Shrinkage::soft)), threshold * step, 1e-14);
    EXPECT_NEAR(std::abs(shrunk(above, threshold, Shrinkage::garrote)), 2.0 * threshold * step, 1e-14);
    EXPECT_EQ(shrunk(above, threshold, Shrinkage::hard), above);
    for (const Shrinkage rule : kShrinkages) EXPECT_EQ(shrunk(side * threshold, threshold, rule), 0.0);
  }
}

TEST(Shrink, GarroteLiesBetweenSoftAndHardAndNeverTurnsTheSign) {
  for (const double d : gaussian(2000, 1)) {
    const double soft = shrunk(d, 0.5, Shrinkage::soft);
    const double garrote = shrunk(d, 0.5, Shrinkage::garrote);
    EXPECT_LE(std::abs(soft), std::abs(garrote));
    EXPECT_LE(std::abs(garrote), std::abs(shrunk(d, 0.5, Shrinkage::hard)));
    EXPECT_GE(soft * d, 0.0);
    EXPECT_GE(garrote * d, 0.0);
  }
}

TEST(Shrink, ThresholdZeroChangesNothing) {
  const std::vector<double> d = {-1e300, -3.0, -5e-324, 0.0, 5e-324, 1e-300, 2.0, 1e300};
  for (const Shrinkage rule : kShrinkages) EXPECT_EQ(shrunk(d, 0.0, rule), d);
}

TEST(Shrink, ScalesWithTheUnitToTheLastBit) {
  const std::vector<double> d = gaussian(1000, 2);
  for (const double unit : {0x1p-600, -0x1p-3, 0x1p900}) {
    std::vector<double> scaled = d;
    for (double& v : scaled) v *= unit;
    for (const Shrinkage rule : kShrinkages) {
      std::vector<double> expected = shrunk(d, 0.7, rule);
      for (double& v : expected) v *= unit;
      EXPECT_EQ(shrunk(scaled, 0.7 * std::abs(unit), rule), expected) << unit;
    }
  }
}

/// Mean squared error of a rule for a coefficient `truth` in unit Gaussian noise, by the midpoint rule.
double risk(double truth, double threshold, Shrinkage rule) {
  constexpr double kStep = 1e-3;
  double sum = 0.0;
  for (double z = -9.0 + 0.5 * kStep; z < 9.0; z += kStep) {
    const double error = shrunk(truth + z, threshold, rule) - truth;
    sum += error * error * std::exp(-0.5 * z * z);
  }
  return sum * kStep / std::sqrt(2.0 * std::numbers::pi);
}

TEST(Shrink, RisksAreThosePublishedForGaussianNoise) {
  const double t = 2.5;
  const double density = std::exp(-0.5 * t * t) / std::sqrt(2.0 * std::numbers::pi);
  const double tail = 0.5 * std::erfc(t / std::numbers::sqrt2);
  // Bruce and Gao 1996. A jump of up to T^2 in the integrand costs at most kStep/2 T^2 phi(T) = 5.5e-5 on each side.
  EXPECT_NEAR(risk(0.0, t, Shrinkage::soft), 2.0 * ((1.0 + t * t) * tail - t * density), 1e-6);
  EXPECT_NEAR(risk(0.0, t, Shrinkage::hard), 2.0 * (t * density + tail), 1.2e-4);
  // A coefficient far above the threshold: soft pays T^2 for its bias, hard nothing, garrote T^4/truth^2.
  EXPECT_NEAR(risk(40.0, t, Shrinkage::soft), 1.0 + t * t, 1e-6);
  EXPECT_NEAR(risk(40.0, t, Shrinkage::hard), 1.0, 1e-6);
  EXPECT_NEAR(risk(40.0, t, Shrinkage::garrote), 1.0, 0.05);
}

TEST(Shrink, RiskOrderTurnsRoundBetweenNoSignalAndALargeOne) {
  // Gao 1998: without a signal the more a rule removes the better, with a large one the other way round.
  for (const double t : {1.0, 2.0, 3.0, 4.0}) {
    EXPECT_LT(risk(0.0, t, Shrinkage::soft), risk(0.0, t, Shrinkage::garrote));
    EXPECT_LT(risk(0.0, t, Shrinkage::garrote), risk(0.0, t, Shrinkage::hard));
    EXPECT_GT(risk(t + 6.0, t, Shrinkage::soft), risk(t + 6.0, t, Shrinkage::garrote));
    EXPECT_GT(risk(t + 6.0, t, Shrinkage::garrote), risk(t + 6.0, t, Shrinkage::hard));
  }
}

/// By sorting everything.
double plain_noise_level(std::vector<double> details) {
  for (double& d : details) d = std::abs(d);
  std::sort(details.begin(), details.end());
  const std::size_t n = details.size();
  return 0.5 * (details[(n - 1) / 2] + details[n / 2]) / 0.6745;
}

TEST(NoiseLevel, IsTheMedianSizeOverItsValueForUnitNoise) {
  EXPECT_EQ(noise_level({}), 0.0);
  EXPECT_DOUBLE_EQ(noise_level(std::vector{-6.745}), 10.0);
  EXPECT_DOUBLE_EQ(noise_level(std::vector{3.0, -1.0, 2.0}), 2.0 / 0.6745);
  EXPECT_DOUBLE_EQ(noise_level(std::vector{-4.0, 1.0, 2.0, -3.0}), 2.5 / 0.6745);
}

TEST(NoiseLevel, IsExactForEveryLengthAndOrder) {
  // From 16384 values on the median is looked for between two values of a sample of every 256th.
  for (const std::size_t n : {1U, 2U, 5U, 1000U, 16383U, 16384U, 16385U, 50000U, 50001U}) {
    std::vector<double> d = gaussian(n, n);
    EXPECT_EQ(noise_level(d), plain_noise_level(d)) << n;
    std::sort(d.begin(), d.end());
    EXPECT_EQ(noise_level(d), plain_noise_level(d)) << n << " sorted";
    for (double& v : d) v = std::round(v);
    EXPECT_EQ(noise_level(d), plain_noise_level(d)) << n << " with ties";
    for (std::size_t i = 0; i < n; i += 256) d[i] = 100.0 + static_cast<double>(i);
    EXPECT_EQ(noise_level(d), plain_noise_level(d)) << n << " where the sample misleads";
    for (std::size_t i = 0; i < n; ++i) d[i] = i < n / 2 ? 1.0 : -2.0;
    EXPECT_EQ(noise_level(d), plain_noise_level(d)) << n << " in two heaps";
  }
}

TEST(NoiseLevel, IsExactWhereTheSampleSeesTheUpperOfTwoHeapsAlone) {
  // Half are 1 and half are 2, and among the latter every 256th: the lower middle value is below the bracket.
  std::vector<double> d(40'000, 1.0);
  std::size_t large = 0;
  for (std::size_t i = 0; i < d.size(); i += 256, ++large) d[i] = 2.0;
  for (std::size_t i = 1; large < d.size() / 2; ++i) {
    if (d[i] == 2.0) continue;
    d[i] = 2.0;
    ++large;
  }
  EXPECT_EQ(noise_level(d), 1.5 / 0.6745);
}

TEST(NoiseLevel, EstimatesTheStandardDeviationAndBearsOutliers) {
  constexpr std::size_t kCount = 100'000;
  std::vector<double> d = gaussian(kCount, 7);
  for (double& v : d) v *= 0.02;
  // The median of |x| has standard error 1/(2 f sqrt(n)) with density f = 2 phi(0.6745) = 0.6356: sigma's is
  // 1.166/sqrt(n) = 0.37 %; four of them.
  EXPECT_NEAR(noise_level(d) / 0.02, 1.0, 0.015);
  for (std::size_t i = 0; i < kCount; i += 5) d[i] = 1e6;
  // A fifth at infinity: the median of the rest is their quantile 0.5/0.8, 0.8871 for |x| of unit noise.
  EXPECT_NEAR(noise_level(d) / 0.02, 0.8871 / 0.6745, 0.02);
}

TEST(NoiseLevel, SeesNoNoiseWhereMostDetailsAreZero) {
  EXPECT_EQ(noise_level(std::vector{0.0, 0.0, 0.0, 5.0, 5.0}), 0.0);
}

TEST(UniversalThreshold, IsSigmaTimesTheRootOfTwiceTheLogarithm) {
  // sqrt(2 ln n) as tabulated by Donoho and Johnstone (1994, table 2).
  EXPECT_NEAR(universal_threshold(1.0, 64), 2.884, 5e-4);
  EXPECT_NEAR(universal_threshold(1.0, 1024), 3.723, 5e-4);
  EXPECT_DOUBLE_EQ(universal_threshold(0.3, 4096.5), 0.3 * std::sqrt(2.0 * std::log(4096.5)));
  EXPECT_EQ(universal_threshold(1.0, 1.0), 0.0);
  EXPECT_EQ(universal_threshold(1.0, 0.0), 0.0);
  EXPECT_EQ(universal_threshold(1.0, 0.25), 0.0);
}

TEST(UniversalThreshold, IsSeldomExceededByAnyOfTheNoise) {
  constexpr int kSeeds = 400;
  constexpr std::size_t kCount = 1024;
  const double threshold = universal_threshold(1.0, kCount);
  int exceeded = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const std::vector<double> d = gaussian(kCount, 100 + static_cast<std::uint64_t>(seed));
    exceeded += std::ranges::any_of(d, [&](double v) { return std::abs(v) > threshold; }) ? 1 : 0;
  }
  // 1 - (1 - 2 Q(3.7233))^1024 = 0.182 of the records; four binomial standard deviations of 0.0193.
  EXPECT_NEAR(static_cast<double>(exceeded) / kSeeds, 0.182, 0.077);
}

}  // namespace
}  // namespace soak::calib::signal
