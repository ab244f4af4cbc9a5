// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/noise/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "calib/signal/spectrum/spectrum.h"

namespace soak::calib::signal {
namespace {

/// Allan variance at `m` samples by its definition: half the mean square of the differences of adjacent means that do
/// not overlap.
double allan_variance(std::span<const double> rate, std::size_t m) {
  std::vector<double> means;
  for (std::size_t i = 0; i + m <= rate.size(); i += m) {
    means.push_back(std::accumulate(rate.begin() + static_cast<std::ptrdiff_t>(i),
                                    rate.begin() + static_cast<std::ptrdiff_t>(i + m), 0.0) /
                    static_cast<double>(m));
  }
  double sum = 0.0;
  for (std::size_t i = 1; i < means.size(); ++i) sum += std::pow(means[i] - means[i - 1], 2);
  return 0.5 * sum / static_cast<double>(means.size() - 1);
}

/// Each estimated Allan variance against the expected one. With k differences of adjacent means, which are correlated
/// with their neighbours by -1/2 at most, its relative standard deviation is at most sqrt(3/k); five of them.
template <class Expected>
void expect_allan_variance(std::span<const double> rate, const Expected& expected) {
  for (std::size_t m = 1; m <= rate.size() / 32; m *= 4) {
    const double k = static_cast<double>(rate.size() / m - 1);
    EXPECT_NEAR(allan_variance(rate, m) / expected(static_cast<double>(m)), 1.0, 5.0 * std::sqrt(3.0 / k)) << m;
  }
}

constexpr std::size_t kSamples = 1 << 17;
constexpr double kNoiseRate_hz = 20.0;
constexpr NoiseSource kSource{kNoiseRate_hz, 11};

TEST(WhiteNoise, HasTheAllanVarianceOfAnAngleRandomWalk) {
  expect_allan_variance(white_noise(kSamples, 0.3, kSource), [](double m) { return 0.09 * kNoiseRate_hz / m; });
}

TEST(FlickerNoise, HasTheSameAllanVarianceAtEveryAveragingTimeFromOneSampleOn) {
  const double flat = 4.0 * 2.0 * std::numbers::ln2 / std::numbers::pi;
  expect_allan_variance(flicker_noise(kSamples, 2.0, kSource), [&](double) { return flat; });
}

TEST(FlickerNoise, DoesNotDependOnTheRate) {
  EXPECT_EQ(flicker_noise(100, 1.0, {1.0, 5}), flicker_noise(100, 1.0, {200.0, 5}));
}

TEST(FlickerNoise, HasItsAllanVarianceInShortRecordsToo) {
  // Mean over 4000 seeds of (y1 - y0)^2/2 and of the same for means of two, in records of 4 samples: a chi-squared
  // variable of one degree of freedom each, relative standard deviation sqrt(2/4000) = 2.2 %; five of them.
  double single = 0.0;
  double pairs = 0.0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const std::vector<double> y = flicker_noise(4, 1.0, {1.0, seed});
    single += 0.5 * std::pow(y[1] - y[0], 2) / 4000.0;
    pairs += 0.5 * std::pow(0.5 * (y[3] + y[2] - y[1] - y[0]), 2) / 4000.0;
  }
  const double expected = 2.0 * std::numbers::ln2 / std::numbers::pi;
  EXPECT_NEAR(single / expected, 1.0, 0.11);
  EXPECT_NEAR(pairs / expected, 1.0, 0.11);
}

TEST(FlickerNoise, AgreesWithASumOfGaussMarkovProcesses) {
  // Processes of equal variance with correlation times spaced by a factor of 2 make a PSD that follows 1/f between the
  // extreme times: sum_j 4 s^2 T_j/(1 + (2 pi f T_j)^2) -> s^2/(f ln 2) (the sum over j as an integral; the ripple at a
  // spacing of 2 is below 0.1 %). Equal to B^2/(pi f): s^2 = B^2 ln2/pi. Times of 1/8 to 2^17 samples leave the
  // averaging times of 16 to 1024 samples 1 % short of the whole 1/f noise at most.
  const double sigma = std::sqrt(std::numbers::ln2 / std::numbers::pi);
  std::vector<double> sum(kSamples, 0.0);
  std::uint64_t seed = 100;
  for (double time = 0.125; time <= 131072.0; time *= 2.0) {
    const std::vector<double> process = gauss_markov_noise(kSamples, sigma, time, {1.0, seed++});
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += process[i];
  }
  const std::vector<double> flicker = flicker_noise(kSamples, 1.0, kSource);
  for (const std::size_t m : {16U, 64U, 256U, 1024U}) {
    // Two estimates, each as in expect_allan_variance(), four standard deviations, and the 1 %.
    const double k = static_cast<double>(kSamples / m - 1);
    EXPECT_NEAR(allan_variance(flicker, m) / allan_variance(sum, m), 1.0, 0.01 + 4.0 * std::sqrt(6.0 / k)) << m;
  }
}

TEST(RandomWalk, HasTheAllanVarianceOfAContinuousWalkFromOneSampleOn) {
  expect_allan_variance(random_walk(kSamples, 0.1, kSource), [](double m) { return 0.01 * m / kNoiseRate_hz / 3.0; });
}

TEST(RateRamp, RisesFromZeroByTheRampEachSecond) {
  EXPECT_EQ(rate_ramp(4, 6.0, 2.0), (std::vector<double>{0.0, 3.0, 6.0, 9.0}));
}

TEST(QuantizationNoise, HasTheAllanVarianceOfARoundedAngle) {
  expect_allan_variance(quantization_noise(kSamples, 0.01, kSource),
                        [](double m) { return 3.0 * 1e-4 * kNoiseRate_hz * kNoiseRate_hz / (m * m); });
}

TEST(QuantizationNoise, SumsToAnAngleThatStaysWithinOneStep) {
  double angle = 0.0;
  for (const double rate : quantization_noise(1000, 0.5, kSource)) {
    angle += rate / kNoiseRate_hz;
    EXPECT_LE(std::abs(angle), std::sqrt(12.0) * 0.5 * (1.0 + 1e-12));
  }
}

TEST(GaussMarkovNoise, HasItsVarianceAndItsCorrelationFromTheFirstSampleOn) {
  // Over 20000 seeds: x_0^2, x_0 x_3 with a relative standard deviation of sqrt(2/20000) = 1 %; five of them.
  double square = 0.0;
  double product = 0.0;
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    const std::vector<double> x = gauss_markov_noise(4, 2.0, 0.5, {10.0, seed});
    square += x[0] * x[0] / 20000.0;
    product += x[0] * x[3] / 20000.0;
  }
  EXPECT_NEAR(square, 4.0, 0.2);
  EXPECT_NEAR(product, 4.0 * std::exp(-0.3 / 0.5), 0.2);
}

TEST(SimulatedNoise, IsDeterminedByItsSeedAndIndependentBetweenKinds) {
  EXPECT_EQ(white_noise(50, 1.0, {1.0, 3}), white_noise(50, 1.0, {1.0, 3}));
  EXPECT_NE(white_noise(50, 1.0, {1.0, 3}), white_noise(50, 1.0, {1.0, 4}));
  const std::vector<double> white = white_noise(10000, 1.0, {1.0, 3});
  const std::vector<double> walk = random_walk(10001, 1.0, {1.0, 3});
  double product = 0.0;
  for (std::size_t i = 0; i < white.size(); ++i) product += white[i] * (walk[i + 1] - walk[i]) / 10000.0;
  EXPECT_NEAR(product, 0.0, 5.0 / std::sqrt(10000.0));
}

TEST(SimulatedNoise, ComesInEveryLengthFromNoneOn) {
  for (const std::size_t count : {0U, 1U, 2U, 3U, 5U}) {
    EXPECT_EQ(white_noise(count, 1.0, kSource).size(), count);
    EXPECT_EQ(flicker_noise(count, 1.0, kSource).size(), count);
    EXPECT_EQ(random_walk(count, 1.0, kSource).size(), count);
    EXPECT_EQ(gauss_markov_noise(count, 1.0, 1.0, kSource).size(), count);
    EXPECT_EQ(quantization_noise(count, 1.0, kSource).size(), count);
  }
}

/// Power law of the PSD between two frequencies: slope of ln density over ln frequency, by least squares.
double spectral_slope(const std::vector<double>& rate, double from_hz, double to_hz) {
  const auto spectrum = welch(rate, kNoiseRate_hz, {.section = 4096});
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t k = 0; k < spectrum->density.size(); ++k) {
    if (spectrum->frequency_hz[k] < from_hz || spectrum->frequency_hz[k] > to_hz) continue;
    const double x = std::log(spectrum->frequency_hz[k]);
    const double y = std::log(spectrum->density[k]);
    n += 1.0, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

TEST(SimulatedNoise, HasTheSpectralSlopesOfItsKind) {
  // From 0.05 Hz (10 spacings from 0: the window's leakage is past) to 1 Hz (a twentieth of the rate: averaging over
  // the sample interval takes 0.8 % off the density). About 195 values of 120 degrees of freedom scatter by 0.13 in the
  // logarithm, over a spread of ln f of 0.7: 0.13/(0.7 sqrt(195/1.5)) = 0.016; four of them.
  EXPECT_NEAR(spectral_slope(white_noise(kSamples, 1.0, kSource), 0.05, 1.0), 0.0, 0.065);
  EXPECT_NEAR(spectral_slope(flicker_noise(kSamples, 1.0, kSource), 0.05, 1.0), -1.0, 0.065);
  EXPECT_NEAR(spectral_slope(random_walk(kSamples, 1.0, kSource), 0.05, 1.0), -2.0, 0.065);
}

/// Mean of density * f^power between 0.05 and 1 Hz.
double spectral_level(const std::vector<double>& rate, double power) {
  const auto spectrum = welch(rate, kNoiseRate_hz, {.section = 4096});
  double sum = 0.0, n = 0.0;
  for (std::size_t k = 0; k < spectrum->density.size(); ++k) {
    const double f = spectrum->frequency_hz[k];
    if (f < 0.05 || f > 1.0) continue;
    sum += spectrum->density[k] * std::pow(f, power), n += 1.0;
  }
  return sum / n;
}

TEST(SimulatedNoise, HasTheSpectralDensityOfItsCoefficient) {
  // Mean of 195 densities of 120 degrees of freedom, neighbours correlated by the window: 0.13/sqrt(195/1.5) = 1.1 %;
  // four of them and the 0.8 % of the averaging.
  EXPECT_NEAR(spectral_level(white_noise(kSamples, 0.3, kSource), 0.0) / (2.0 * 0.09), 1.0, 0.055);
  EXPECT_NEAR(spectral_level(flicker_noise(kSamples, 0.3, kSource), 1.0) / (0.09 / std::numbers::pi), 1.0, 0.055);
  const double walk = 2.0 * 0.09 / std::pow(2.0 * std::numbers::pi, 2);
  EXPECT_NEAR(spectral_level(random_walk(kSamples, 0.3, kSource), 2.0) / walk, 1.0, 0.055);
}

}  // namespace
}  // namespace soak::calib::signal
