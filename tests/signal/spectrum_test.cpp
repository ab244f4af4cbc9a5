// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/spectrum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <vector>

#include "calib/signal/noise/noise.h"

namespace soak::calib::signal {
namespace {

constexpr double kQuietNaN = std::numeric_limits<double>::quiet_NaN();

double power(const Spectrum& spectrum) {
  return std::accumulate(spectrum.density.begin(), spectrum.density.end(), 0.0) *
         (spectrum.frequency_hz[1] - spectrum.frequency_hz[0]);
}

std::vector<double> sine(std::size_t count, double amplitude, double cycles_per_sample) {
  std::vector<double> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    samples[i] = amplitude * std::sin(2.0 * std::numbers::pi * cycles_per_sample * static_cast<double>(i) + 0.4);
  }
  return samples;
}

TEST(Welch, AgreesWithScipy) {
  std::ifstream file(SOAK_TEST_FOLDER "/data/vectors/welch.json");
  const nlohmann::json vectors = nlohmann::json::parse(file);
  const auto signal = vectors.at("signal").get<std::vector<double>>();
  for (const auto& c : vectors.at("cases")) {
    const std::string detrend = c.at("detrend");
    const WelchOptions options{.section = c.at("section"),
                               .overlap = c.at("overlap"),
                               .detrend = detrend == "none"   ? Detrend::none
                                          : detrend == "mean" ? Detrend::mean
                                                              : Detrend::line};
    const auto spectrum = welch(signal, vectors.at("rate_hz"), options);
    ASSERT_TRUE(spectrum);
    const auto expected = c.at("density").get<std::vector<double>>();
    ASSERT_EQ(spectrum->density.size(), expected.size());
    // 1e-12 of the largest density: what leaks from it is rounded by as much.
    const double largest = *std::max_element(expected.begin(), expected.end());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      EXPECT_NEAR(spectrum->density[k], expected[k], 1e-12 * largest) << options.section << " " << k;
    }
  }
}

TEST(Welch, OfWhiteNoiseIntegratesToItsVariance) {
  // Half-overlapping Hann sections use the variance of 1e5 samples to about sqrt(2/1e5 * 1.06) = 0.46 %; five of them.
  // The mean taken off each section costs 1.5/512 more in the two lowest frequencies.
  const auto spectrum = welch(white_noise(100000, 0.7, {50.0, 1}), 50.0, {.section = 512});
  EXPECT_NEAR(power(*spectrum) / (0.49 * 50.0), 1.0, 0.026);
}

TEST(Welch, OfASineInOneBinIntegratesToHalfItsSquare) {
  for (const std::size_t section : {64U, 63U}) {  // even and odd
    const auto spectrum = welch(sine(1000, 3.0, 8.0 / static_cast<double>(section)), 10.0,
                                {.section = section, .detrend = Detrend::none});
    // A Hann window spreads it over bins 7 to 9, all of them inside: exact but for rounding.
    EXPECT_NEAR(power(*spectrum), 4.5, 1e-12);
    EXPECT_NEAR(spectrum->density[8] * 10.0 / static_cast<double>(section), 4.5 * 2.0 / 3.0, 1e-12);
  }
}

TEST(Welch, DoesNotDoubleZeroNorHalfTheRate) {
  // A constant c: its windowed section has the power c^2 sum(w)^2/sum(w^2)/n at 0 = 2/3 c^2; the neighbour at the first
  // frequency has 1/4 of that on either side, folded: the sum is c^2. The same mirrored for (-1)^i c.
  const std::vector<double> constant(256, 2.0);
  const auto low = welch(constant, 32.0, {.section = 32, .detrend = Detrend::none});
  EXPECT_NEAR(low->density[0] * 1.0, 4.0 * 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(power(*low), 4.0, 1e-12);
  std::vector<double> alternating(256);
  for (std::size_t i = 0; i < 256; ++i) alternating[i] = i % 2 == 0 ? 2.0 : -2.0;
  const auto high = welch(alternating, 32.0, {.section = 32, .detrend = Detrend::none});
  EXPECT_NEAR(high->density[16], 4.0 * 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(power(*high), 4.0, 1e-12);
}

/// Discrete Fourier transform by its definition.
std::complex<double> fourier_sum(const std::vector<double>& x, std::size_t k) {
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sum += x[i] * std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(i * k % x.size()) /
                                      static_cast<double>(x.size()));
  }
  return sum;
}

TEST(Welch, TransformsSectionsOfAnyLength) {
  // 1009 and 997 are prime, 1001 = 7 * 11 * 13, 1000 and 1024 have small factors.
  for (const std::size_t n : {8U, 11U, 997U, 1000U, 1001U, 1009U, 1024U}) {
    const std::vector<double> x = white_noise(n, 1.0, {1.0, n});
    const auto spectrum = welch(x, 1.0, {.section = n, .detrend = Detrend::none});
    std::vector<double> windowed(n);
    double squares = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double w = std::pow(std::sin(std::numbers::pi * static_cast<double>(i) / static_cast<double>(n)), 2);
      windowed[i] = w * x[i];
      squares += w * w;
    }
    for (std::size_t k = 1; 2 * k < n; k += 1 + n / 50) {
      // densities near 2, sums of n rounded products
      EXPECT_NEAR(spectrum->density[k], 2.0 * std::norm(fourier_sum(windowed, k)) / squares, 1e-11) << n << " " << k;
    }
  }
}

TEST(Welch, LeavesOutSectionsThatLackASample) {
  std::vector<double> x = white_noise(1000, 1.0, {1.0, 2});
  const std::vector<double> first(x.begin(), x.begin() + 500);
  x[500] = kQuietNaN;
  const auto gap = welch(x, 1.0, {.section = 100, .overlap = 0.0});
  EXPECT_EQ(gap->sections, 9U);
  x.resize(600);
  EXPECT_EQ(welch(x, 1.0, {.section = 100, .overlap = 0.0})->density,
            welch(first, 1.0, {.section = 100, .overlap = 0.0})->density);
}

TEST(Welch, StatesTheDegreesOfFreedomThatItsScatterHas) {
  // Scatter of the density over seeds: relative variance 2/dof. 500 seeds, 29 frequencies two apart: the estimate of
  // the variance has about 500 * 29 degrees of freedom, 1.2 % (a little more, chi-squared has a tail); six of them.
  for (const double overlap : {0.0, 0.5, 0.75}) {
    double stated = 0.0, scatter = 0.0;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
      const auto spectrum = welch(white_noise(1024, 1.0, {1.0, seed}), 1.0, {.section = 128, .overlap = overlap});
      stated = spectrum->degrees_of_freedom;
      for (std::size_t k = 4; k < 61; k += 2) scatter += std::pow(spectrum->density[k] / 2.0 - 1.0, 2) / (500.0 * 29.0);
    }
    EXPECT_NEAR(2.0 / scatter / stated, 1.0, 0.07) << overlap;
  }
}

TEST(Welch, CountsDegreesOfFreedomOfSectionsOnEitherSideOfAGapAsIndependent) {
  std::vector<double> x(300, 0.0);
  for (std::size_t i = 100; i < 200; ++i) x[i] = kQuietNaN;
  const auto apart = welch(x, 1.0, {.section = 100});
  EXPECT_EQ(apart->sections, 2U);
  EXPECT_DOUBLE_EQ(apart->degrees_of_freedom, 4.0);
}

TEST(Welch, RefusesWhatHasNoSpectrum) {
  const std::vector<double> x = white_noise(100, 1.0, {1.0, 2});
  EXPECT_FALSE(welch(x, 0.0, {}));
  EXPECT_FALSE(welch(x, kQuietNaN, {}));
  EXPECT_FALSE(welch(x, std::numeric_limits<double>::infinity(), {}));
  EXPECT_FALSE(welch(std::vector<double>(7, 1.0), 1.0, {}));
  EXPECT_FALSE(welch(x, 1.0, {.section = 7}));
  EXPECT_FALSE(welch(x, 1.0, {.overlap = 0.96}));
  EXPECT_FALSE(welch(x, 1.0, {.overlap = -0.1}));
  EXPECT_FALSE(welch(x, 1.0, {.overlap = kQuietNaN}));
  EXPECT_FALSE(welch(std::vector<double>(100, kQuietNaN), 1.0, {}));
  std::vector<double> infinite = x;
  infinite[3] = std::numeric_limits<double>::infinity();
  const auto refused = welch(infinite, 1.0, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "sample 3");
}

TEST(Welch, ReducesTheSectionToAShorterSignal) {
  const auto spectrum = welch(white_noise(100, 1.0, {1.0, 2}), 1.0, {});
  EXPECT_EQ(spectrum->sections, 1U);
  EXPECT_EQ(spectrum->density.size(), 51U);
  EXPECT_DOUBLE_EQ(spectrum->frequency_hz.back(), 0.5);
  EXPECT_DOUBLE_EQ(spectrum->degrees_of_freedom, 2.0);
}

}  // namespace
}  // namespace soak::calib::signal
