// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/statistics.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "base/random.h"
#include "calib/segments/segmentation.h"
#include "calib/signal/noise/mean_error.h"
#include "calib/signal/noise/noise.h"

namespace soak::calib {
namespace {

TEST(Describe, KeepsTheDigitsOfSmallScatterOnALargeMean) {
  std::vector<double> samples;
  for (int i = 0; i < 1000; ++i) samples.push_back(1e6 + (i % 2 == 0 ? 1e-4 : -1e-4));
  const SensorStatistics s = describe(samples);
  EXPECT_NEAR(s.mean, 1e6, 1e-9);
  EXPECT_NEAR(s.variance, 1e-8 * 1000 / 999, 1e-11);
}

TEST(Describe, PassesOverMissingSamples) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SensorStatistics s = describe(std::vector<double>{nan, 1.0, nan, 2.0, 3.0});
  EXPECT_EQ(s.count, 3U);
  EXPECT_DOUBLE_EQ(s.mean, 2.0);
  EXPECT_EQ(describe(std::vector<double>{nan}).count, 0U);
}

/// Root mean square of (mean of a series)/(its stated standard error) over many seeds: 1 where the statement is honest.
double honesty(double correlation, std::size_t length, int seeds) {
  double squares = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    base::Random random(static_cast<std::uint64_t>(seed), 7);
    std::vector<double> series(length);
    double state = random.gaussian() / std::sqrt(1.0 - correlation * correlation);
    for (double& v : series) {
      state = correlation * state + random.gaussian();
      v = state;
    }
    const SensorStatistics s = describe(series);
    squares += s.mean * s.mean / (s.standard_error * s.standard_error);
  }
  return std::sqrt(squares / seeds);
}

TEST(Describe, StandardErrorOfWhiteNoiseIsHonest) { EXPECT_NEAR(honesty(0.0, 600, 400), 1.0, 0.12); }

TEST(Describe, StandardErrorRespectsCorrelation) {
  // For a first-order process with correlation 0.9 the white-noise formula would be wrong by sqrt(19) = 4.4.
  const double ratio = honesty(0.9, 2000, 400);
  EXPECT_GT(ratio, 0.85);
  EXPECT_LT(ratio, 1.35);
}

TEST(Describe, GroupingLongStretchesDoesNotHideCorrelation) { EXPECT_LT(honesty(0.99, 20000, 100), 1.4); }

TEST(Describe, TakesTheStandardErrorThatDoesNotAverageDown) {
  // Flicker noise: the standard error of independent samples would be some twenty times too small.
  std::vector<double> samples = signal::flicker_noise(6000, 1.0, {1.0, 1});
  const double expected = signal::standard_error_of_mean(samples).standard_error;
  EXPECT_GT(expected, 0.3);
  samples.insert(samples.begin() + 100, std::numeric_limits<double>::quiet_NaN());
  EXPECT_DOUBLE_EQ(describe(samples).standard_error, expected);
}

/// Root mean square of (mean of rounded samples less the true mean)/(its stated error), for true means anywhere between
/// two steps of 0.01.
double honesty_of_rounded(double noise, std::size_t length) {
  constexpr int kSegments = 200;
  constexpr double kStep = 0.01;
  double squares = 0.0;
  for (int i = 0; i < kSegments; ++i) {
    base::Random random(static_cast<std::uint64_t>(i), 9);
    const double truth = 9.8 + kStep * random.uniform(0.0, 1.0);
    std::vector<double> samples(length);
    for (double& v : samples) v = kStep * std::round((truth + noise * random.gaussian()) / kStep);
    const SensorStatistics s = describe(samples, kStep);
    squares += std::pow((s.mean - truth) / s.standard_error, 2) / kSegments;
  }
  return std::sqrt(squares);
}

TEST(Describe, StatesWhatACoarseStepHides) {
  // The ratio of 200 uniform errors has a relative standard deviation of sqrt((9/5 - 1)/200)/2 = 3 %; noise of a few
  // tenths of a step makes the error less than what is stated where only one or two codes show.
  for (const double noise : {0.0, 0.001, 0.002, 0.003, 0.005, 0.02}) {
    const double ratio = honesty_of_rounded(noise, 1000);
    EXPECT_LT(ratio, 1.2) << noise;
    EXPECT_GT(ratio, 0.25) << noise;
  }
}

TEST(RoundingError, IsThatOfAUniformErrorForOneNumberAndVanishesUnderNoise) {
  EXPECT_DOUBLE_EQ(rounding_error(0.01, 0.0), 0.01 / std::sqrt(12.0));
  EXPECT_EQ(rounding_error(0.0, 0.0), 0.0);
  EXPECT_LT(rounding_error(0.01, 1e-4), 1e-9);
  // Continuous where the noise begins to show: the sum of 1/k^2 is cut off after 2 % of it.
  EXPECT_NEAR(rounding_error(1.0, 1.0 / 12.0 + 1e-9), rounding_error(1.0, 0.0), 0.02 * rounding_error(1.0, 0.0));
}

TEST(RoundingError, IsTheRootMeanSquareOverAllMeansBetweenTwoSteps) {
  // Mean of a rounded Gaussian by its distribution: sum_k k (P(x < k + 1/2) - P(x < k - 1/2)).
  constexpr double kSigma = 0.45;
  const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  double squares = 0.0;
  double variances = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double truth = (i + 0.5) / 1000.0;
    double mean = 0.0;
    double square = 0.0;
    for (int k = -4; k <= 5; ++k) {
      const double p = below((k + 0.5 - truth) / kSigma) - below((k - 0.5 - truth) / kSigma);
      mean += p * k;
      square += p * k * k;
    }
    squares += (mean - truth) * (mean - truth) / 1000.0;
    variances += (square - mean * mean + (mean - truth) * (mean - truth)) / 1000.0;
  }
  // About the true mean the variance is sigma^2 + 1/12 on the average (Sheppard), which the error follows from.
  EXPECT_NEAR(variances, kSigma * kSigma + 1.0 / 12.0, 1e-3);
  EXPECT_NEAR(rounding_error(1.0, kSigma * kSigma + 1.0 / 12.0), std::sqrt(squares), 1e-6);
  EXPECT_GT(squares, 1e-5);
}

TEST(Describe, KnowsNoNumberBetterThanFloat32) {
  const SensorStatistics s = describe(std::vector<double>(1000, 9.8));
  EXPECT_NEAR(s.standard_error, 9.8 * 0x1p-23 / std::sqrt(12.0), 1e-15);
}

TEST(Describe, StaysFiniteForHugeNumbers) {
  const std::vector<double> samples = {1e300, -1e300, 2e300};
  const SensorStatistics s = describe(samples);
  EXPECT_NEAR(s.mean, 2e300 / 3.0, 1e286);
  EXPECT_TRUE(std::isfinite(s.standard_error));
  EXPECT_GT(s.standard_error, 1e299);
}

TEST(OutputStep, IsTheLatticeOfTheSamplesAndZeroWithoutOne) {
  base::Random random(1, 5);
  std::vector<double> fine(200000);
  std::vector<double> coarse;
  for (double& v : fine) v = 9.8 + 0.001 * random.gaussian();
  // Slow drift through three steps, as a quiet sensor goes; stored in float32.
  for (std::size_t i = 0; i < fine.size(); ++i) {
    coarse.push_back(static_cast<float>(0.01 * std::round((fine[i] + 0.03 * static_cast<double>(i) / 2e5) / 0.01)));
  }
  EXPECT_NEAR(output_step(coarse), 0.01, 1e-5);
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    if (i % 4 != 1) coarse[i] = std::numeric_limits<double>::quiet_NaN();  // a channel of fewer values
  }
  EXPECT_NEAR(output_step(coarse), 0.01, 1e-5);
  EXPECT_EQ(output_step(fine), 0.0);
  EXPECT_EQ(output_step(std::vector<double>(100, 1.0)), 0.0);
  EXPECT_EQ(output_step({}), 0.0);
}

/// Three visits of +X and -X with readings that `read` makes of the true value.
template <class Read>
std::vector<Segment> segments_of(const Read& read) {
  Recording r;
  r.positions = {*position_named("+X"), *position_named("-X")};
  for (std::size_t i = 0; i < 3600; ++i) {
    const double visit = std::floor(static_cast<double>(i) / 1200.0);
    const bool up = i % 1200 < 600;
    const double bias = 0.1 + 0.0137 * std::pow(visit, 1.5);
    r.t_s.push_back(0.1 * static_cast<double>(i));
    r.temp_c.push_back(10.0 * visit);
    r.plateau_c.push_back(10.0 * visit);
    r.position.push_back(up ? 0 : 1);
    for (const Sensor sensor : kSensors) {
      const double force = sensor == Sensor::accel_x ? (up ? 9.8 : -9.8) : 0.0;
      r.sensor[index_of(sensor)].push_back(read(bias + force, i));
    }
  }
  return segment(r)->segments;
}

TEST(Segments, KnowTheOutputStepFromTheWholeRecording) {
  base::Random random(3, 3);
  const auto segments =
      segments_of([&](double v, std::size_t) { return 0.01 * std::round((v + 0.0005 * random.gaussian()) / 0.01); });
  ASSERT_EQ(segments.size(), 6U);
  for (const Segment& s : segments) {
    for (const SensorStatistics& statistics : s.sensor) EXPECT_GT(statistics.standard_error, 5e-4);
  }
}

TEST(Segments, TakeGravityInTwoPositionsForNoOutputStep) {
  // A simulation without noise: what is left is the resolution of float32.
  for (const Segment& s : segments_of([](double v, std::size_t) { return v; })) {
    for (const SensorStatistics& statistics : s.sensor) {
      EXPECT_GT(statistics.standard_error, 0.0);
      EXPECT_LT(statistics.standard_error, 1e-6);
    }
  }
}

TEST(FitLine, RecoversAStraightLineExactly) {
  const Line line = fit_line(std::vector<double>{1, 2, 4}, std::vector<double>{5, 7, 11});
  EXPECT_DOUBLE_EQ(line.slope, 2.0);
  EXPECT_DOUBLE_EQ(line.mean_y - line.slope * line.mean_x, 3.0);
}

std::vector<double> noise_about(double level, double sigma, std::size_t count, std::uint64_t seed) {
  base::Random random(seed);
  std::vector<double> samples(count);
  for (double& v : samples) v = level + sigma * random.gaussian();
  return samples;
}

/// The number with one bit of its float32 form flipped.
double flipped(double value, int bit) {
  return static_cast<double>(std::bit_cast<float>(std::bit_cast<std::uint32_t>(static_cast<float>(value)) ^
                                                  (1U << static_cast<unsigned>(bit))));
}

TEST(Spikes, AFlippedBitIsLeftOutAsIfItsSampleHadNeverCome) {
  // A sample among less than a hundred is more than 1 %.
  for (const std::size_t count : {std::size_t{100}, std::size_t{600}, std::size_t{6000}}) {
    for (const int bit : {16, 20, 25, 30, 31}) {
      for (const std::size_t at : {std::size_t{0}, count / 2, count - 1}) {
        auto samples = noise_about(9.8, 1e-3, count, 4 + count);
        auto others = samples;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(at));
        if (bit == 16 && at != count / 2) continue;  // 62 sigma: no more than a movement that begins
        samples[at] = flipped(samples[at], bit);
        const SensorStatistics s = describe(samples);
        const SensorStatistics truth = describe(others);
        EXPECT_EQ(s.count, count - 1) << count << " samples, bit " << bit << " of number " << at;
        EXPECT_DOUBLE_EQ(s.mean, truth.mean);
        EXPECT_DOUBLE_EQ(s.variance, truth.variance);
        EXPECT_EQ(find_spikes(samples, 0.0), std::vector<std::size_t>{at});
      }
    }
  }
}

TEST(Spikes, NoneIsFoundInAMillionNumbersOfNoiseNorInAFewDigits) {
  EXPECT_TRUE(find_spikes(noise_about(0.0, 1.0, 1'000'000, 8), 0.0).empty());
  std::vector<double> few = noise_about(0.0, 0.2, 6000, 9);
  for (double& v : few) v = std::round(v);  // mostly 0, now and then a step up or down
  EXPECT_TRUE(find_spikes(few, 1.0).empty());
  EXPECT_EQ(describe(few, 1.0).count, few.size());
}

TEST(Spikes, ABurstAStepAndARampAreNone) {
  auto burst = noise_about(0.0, 1.0, 6000, 10);
  for (std::size_t i = 3000; i < 3003; ++i) burst[i] += 1000.0;
  EXPECT_TRUE(find_spikes(burst, 0.0).empty());
  auto turned = noise_about(0.0, 1.0, 6000, 11);
  for (std::size_t i = 3000; i < turned.size(); ++i) turned[i] += 1000.0;
  EXPECT_TRUE(find_spikes(turned, 0.0).empty());
  auto ramp = noise_about(0.0, 1.0, 6000, 12);
  for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] += static_cast<double>(i);
  EXPECT_TRUE(find_spikes(ramp, 0.0).empty());
}

TEST(Spikes, AMovementThatBeginsHasNone) {
  // Two counts of noise, and the first shakes of a hand: from a recording that was turned by hand.
  auto samples = noise_about(33090.0, 2.5, 5000, 14);
  for (const double shake : {33122.0, 33094.0, 33052.0, 33149.0, 33076.0, 33100.0, 33129.0, 33068.0, 33120.0}) {
    samples.push_back(shake);
  }
  EXPECT_TRUE(find_spikes(samples, 1.0).empty());
}

TEST(Spikes, MoreThanOneInAHundredAreNoAccident) {
  auto samples = noise_about(0.0, 1.0, 1000, 13);
  for (std::size_t i = 0; i < 1000; i += 50) samples[i] = 500.0;
  EXPECT_TRUE(find_spikes(samples, 0.0).empty());
  EXPECT_EQ(describe(samples).count, samples.size());
}

}  // namespace
}  // namespace soak::calib
