// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/denoising.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/random.h"
#include "wavelet_support.h"

namespace soak::calib::signal {
namespace {

using Signal = std::vector<double>;

constexpr std::array kRules = {Shrinkage::soft, Shrinkage::hard, Shrinkage::garrote};

using test::wavelet;

Denoised denoised(const Signal& samples, const DenoisingOptions& options, const std::string& name = "db8") {
  auto result = denoise(samples, wavelet(name), options);
  if (!result) throw std::runtime_error(result.error().message);
  return *result;
}

Decomposition decomposed(const Signal& samples, std::size_t levels, Boundary boundary) {
  Decomposition parts;
  if (!decompose(samples, wavelet("db8"), levels, boundary, parts)) throw std::runtime_error("not decomposed");
  return parts;
}

Signal gaussian(std::size_t count, double sigma, std::uint64_t seed) {
  base::Random random(seed);
  Signal values(count);
  for (double& v : values) v = sigma * random.gaussian();
  return values;
}

Signal sampled(std::size_t count, const std::function<double(double)>& function) {
  Signal values;
  for (std::size_t i = 0; i < count; ++i)
    values.push_back(function((0.5 + static_cast<double>(i)) / static_cast<double>(count)));
  return values;
}

Signal step(std::size_t count, std::size_t at, double height) {
  Signal values(count, 0.0);
  std::fill(values.begin() + static_cast<std::ptrdiff_t>(at), values.end(), height);
  return values;
}

Signal operator+(Signal a, const Signal& b) {
  std::transform(a.begin(), a.end(), b.begin(), a.begin(), std::plus<>());
  return a;
}

Signal operator-(Signal a, const Signal& b) {
  std::transform(a.begin(), a.end(), b.begin(), a.begin(), std::minus<>());
  return a;
}

Signal operator*(double factor, Signal a) {
  for (double& v : a) v *= factor;
  return a;
}

double energy(const Signal& values) { return std::inner_product(values.begin(), values.end(), values.begin(), 0.0); }

double rms(const Signal& values) { return std::sqrt(energy(values) / static_cast<double>(values.size())); }

double largest(const Signal& values) {
  double size = 0.0;
  for (const double v : values) size = std::max(size, std::abs(v));
  return size;
}

Signal part(const Signal& values, std::size_t first, std::size_t last) {
  return {values.begin() + static_cast<std::ptrdiff_t>(first), values.begin() + static_cast<std::ptrdiff_t>(last)};
}

std::string text_of_vector_file(const std::string& name) {
  std::ifstream file(std::string(SOAK_TEST_FOLDER) + "/data/vectors/" + name);
  if (!file) throw std::runtime_error("tests/data/vectors/" + name + " is missing");
  return {std::istreambuf_iterator<char>(file), {}};
}

Signal published_signal() {
  std::istringstream lines(text_of_vector_file("wmra_signal.csv"));
  std::string line;
  std::getline(lines, line);
  Signal x;
  while (std::getline(lines, line)) x.push_back(std::stod(line.substr(line.find(',') + 1)));
  return x;
}

TEST(Denoise, ReproducesPyWaveletsReconstructionsAndTrend) {
  const auto published = nlohmann::json::parse(text_of_vector_file("wmra_db8.json"));
  const Signal x = published_signal();
  for (const auto& [mode, boundary] :
       {std::pair{"symmetric", Boundary::symmetric}, std::pair{"periodization", Boundary::periodization}}) {
    const auto& expected = published.at(mode);
    DenoisingOptions options{.levels = expected.at("level").get<std::size_t>(), .boundary = boundary};
    const Denoised soft = denoised(x, options);
    options.shrinkage = Shrinkage::hard;
    const Denoised hard = denoised(x, options);
    EXPECT_LT(largest(soft.signal - expected.at("soft").get<Signal>()), 1e-10) << mode;
    EXPECT_LT(largest(hard.signal - expected.at("hard").get<Signal>()), 1e-10) << mode;
    EXPECT_LT(largest(soft.trend - expected.at("trend").get<Signal>()), 1e-10) << mode;
    EXPECT_NEAR(soft.sigma.front(), expected.at("sigma").get<double>(), 1e-12) << mode;
    for (const double t : soft.thresholds) EXPECT_NEAR(t, expected.at("universal_threshold").get<double>(), 1e-11);
  }
}

TEST(Denoise, TakesThresholdsFromTheFinestDetailsAndTheLengthOfTheSignal) {
  const Signal x = gaussian(3000, 2.0, 1);
  const Denoised result = denoised(x, {.levels = 4, .relaxation = {0.5, 1.5}});
  const Decomposition parts = decomposed(x, 4, Boundary::symmetric);
  const double universal = noise_level(parts.details[0]) * std::sqrt(2.0 * std::log(3000.0));
  const double factors[] = {0.5, 1.5, 1.0, 1.0};
  ASSERT_EQ(result.thresholds.size(), 4U);
  for (std::size_t j = 0; j < 4; ++j) {
    EXPECT_EQ(result.sigma[j], noise_level(parts.details[j]));
    EXPECT_DOUBLE_EQ(result.thresholds[j], factors[j] * universal);
  }
}

TEST(Denoise, TakesThresholdsPerLevelFromItsOwnDetailsAndLength) {
  const Signal x = gaussian(3000, 2.0, 2);
  const Denoised result = denoised(x, {.levels = 12, .noise = NoiseFrom::per_level, .relaxation = {1.0, 0.7}});
  for (std::size_t j = 1; j <= 11; ++j) {
    // [AH05 eq. 4.15]; 3000/2^11 = 1.46.
    const double length = 3000.0 / std::pow(2.0, static_cast<double>(j));
    const double factor = j == 2 ? 0.7 : 1.0;
    EXPECT_DOUBLE_EQ(result.thresholds[j - 1], factor * result.sigma[j - 1] * std::sqrt(2.0 * std::log(length))) << j;
  }
  EXPECT_EQ(result.thresholds[11], 0.0);  // 3000/2^12 < 1
}

TEST(Denoise, TakesAGivenThresholdTimesTheRelaxation) {
  const Denoised result = denoised(gaussian(500, 1.0, 3), {.levels = 3, .relaxation = {1, 0.5}, .threshold = 3.0});
  EXPECT_EQ(result.thresholds, (std::vector<double>{3.0, 1.5, 3.0}));
}

TEST(Denoise, RemovesWhiteNoiseDownToItsShareInTheTrend) {
  constexpr std::size_t kCount = 65536;
  const Signal noise = gaussian(kCount, 0.3, 4);
  for (const NoiseFrom from : {NoiseFrom::finest, NoiseFrom::per_level}) {
    for (const Shrinkage rule : kRules) {
      const Denoised result = denoised(noise, {.levels = 6, .shrinkage = rule, .noise = from});
      // An orthogonal transform keeps sigma in each coefficient: n/64 approximations leave sigma/8, known to 1/sqrt(2
      // n/64) = 2.2 %; four of that. On average 0.16 of the details exceed 4.71 sigma (hard keeps such a one whole:
      // 22 of the 1024 sigma^2, another 1 %); per level, with thresholds from 3.7 on, 1.3 of them.
      EXPECT_NEAR(rms(result.trend) / 0.3, 0.125, 0.125 * 0.09);
      EXPECT_NEAR(rms(result.signal) / 0.3, 0.125, 0.125 * 0.12);
    }
  }
}

TEST(Denoise, TakesAwayTheEnergyOfTheNoise) {
  constexpr std::size_t kCount = 8192;
  const Signal truth = sampled(kCount, [](double t) { return 5.0 * std::sin(4.0 * std::numbers::pi * t); });
  const Signal noise = gaussian(kCount, 0.1, 5);
  for (const Shrinkage rule : {Shrinkage::hard, Shrinkage::garrote, Shrinkage::soft}) {
    const Denoised result = denoised(truth + noise, {.boundary = Boundary::periodization, .shrinkage = rule});
    // Chi-squared with n (1 - 2^-6) degrees of freedom; four standard deviations.
    const double dof = kCount * (1.0 - 1.0 / 64.0);
    const double taken = energy(truth + noise - result.signal) / (0.1 * 0.1);
    EXPECT_NEAR(taken, dof, 4.0 * std::sqrt(2.0 * dof));
    // And not any energy: that of the noise itself, whose share in the approximations (n/64) remains.
    EXPECT_NEAR(rms(result.signal - truth), 0.1 / 8.0, 0.1 / 8.0 * 4.0 / std::sqrt(2.0 * kCount / 64.0));
  }
}

TEST(Denoise, HardThresholdingProjects) {
  // Periodization is orthogonal: what is taken away is at right angles to what is kept, and doing it again at the same
  // threshold takes nothing away.
  const Signal x = gaussian(1024, 1.0, 6);
  const DenoisingOptions options{
      .levels = 5, .boundary = Boundary::periodization, .shrinkage = Shrinkage::hard, .threshold = 1.0};
  const Denoised once = denoised(x, options);
  const Signal taken = x - once.signal;
  EXPECT_GT(energy(taken), 100.0);
  EXPECT_NEAR(std::inner_product(taken.begin(), taken.end(), once.signal.begin(), 0.0), 0.0, 1e-9);
  EXPECT_LT(largest(denoised(once.signal, options).signal - once.signal), 1e-11);
}

/// Samples on either side of a jump that a wavelet of this level can reach.
std::size_t support(const std::string& name, std::size_t levels) {
  return ((std::size_t{1} << levels) - 1) * (wavelet(name).length() - 1) + 1;
}

TEST(Denoise, AStepSmearsNoFurtherThanTheSupportOfTheWavelet) {
  constexpr std::size_t kAt = 2501;
  constexpr std::size_t kCount = 5000;
  const Signal jump = step(kCount, kAt, 1.0);
  for (const std::string name : {"db1", "db2", "db5", "db8", "db10", "sym6"}) {
    for (const std::size_t levels : {1U, 3U, 6U}) {
      // A detail differs from 0 only if its wavelet, which is `reach` long, lies across the step.
      const std::size_t reach = support(name, levels);
      for (const Shrinkage rule : kRules) {
        const Denoised result = denoised(jump, {.levels = levels, .shrinkage = rule, .threshold = 0.2}, name);
        // 0 up to the rounding of 16 terms per level and the error of the filters' print, some 1e-12.
        EXPECT_LT(largest(part(result.signal - jump, 0, kAt - reach)), 1e-10) << name << levels;
        EXPECT_LT(largest(part(result.signal - jump, kAt + reach, kCount)), 1e-10) << name << levels;
        EXPECT_LT(largest(part(result.trend - jump, 0, kAt - reach)), 1e-10) << name << levels;
        EXPECT_LT(largest(part(result.trend - jump, kAt + reach, kCount)), 1e-10) << name << levels;
        EXPECT_GT(largest(result.trend - jump), 0.1) << "the step is not in the trend";
      }
    }
  }
}

TEST(Denoise, AStepInNoiseLeavesTheNoiseOutsideItsSupportAsItWasDenoisedWithoutTheStep) {
  constexpr std::size_t kAt = 4001;
  constexpr std::size_t kCount = 8000;
  const Signal jump = step(kCount, kAt, 2.0);
  const Signal noise = gaussian(kCount, 0.1, 7);
  const std::size_t reach = support("db8", 6);
  for (const Shrinkage rule : kRules) {
    DenoisingOptions options{.levels = 6, .shrinkage = rule};
    const Denoised with = denoised(jump + noise, options);
    // The step hardly moves the median: the universal threshold stays. The same one for the comparison.
    EXPECT_NEAR(with.thresholds.front(), 0.1 * std::sqrt(2.0 * std::log(8000.0)), 0.02);
    options.threshold = with.thresholds.front();
    const Signal without = denoised(noise, options).signal;
    const Signal error = with.signal - jump;
    for (const auto& [first, last] : {std::pair{std::size_t{0}, kAt - reach}, std::pair{kAt + reach, kCount}}) {
      EXPECT_LT(largest(part(error, first, last) - part(without, first, last)), 1e-11);
      // sigma/8 from the approximations; 6 of that (with 2 % of the samples independent) plus the mirrored ends, where
      // approximations count twice: sqrt(2).
      EXPECT_LT(largest(part(error, first, last)), 6.0 * std::numbers::sqrt2 * 0.1 / 8.0);
    }
    // Within, hard and garrote keep the edge: half a support away from it the step stands.
    EXPECT_LT(std::abs(error[kAt - reach / 2]), 0.1);
    EXPECT_LT(std::abs(error[kAt + reach / 2]), 0.1);
  }
}

TEST(Denoise, RulesFollowThePublishedOrderOfRiskAtTheUniversalThreshold) {
  // Donoho and Johnstone's Doppler signal of standard deviation 7 in unit noise. At the universal threshold the bias of
  // soft thresholding weighs most (Bruce and Gao 1996, Gao 1998): hard < garrote < soft. Here 0.12, 0.20 and 0.37 with
  // standard errors of 0.02/sqrt(10): the gaps are more than ten of them.
  Signal doppler = sampled(
      2048, [](double t) { return std::sqrt(t * (1.0 - t)) * std::sin(2.0 * std::numbers::pi * 1.05 / (t + 0.05)); });
  const double mean = std::accumulate(doppler.begin(), doppler.end(), 0.0) / 2048.0;
  for (double& v : doppler) v -= mean;
  doppler = 7.0 / rms(doppler) * doppler;
  double risk[3] = {};
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Signal x = doppler + gaussian(2048, 1.0, 50 + seed);
    for (std::size_t r = 0; r < 3; ++r) {
      risk[r] += 0.1 * energy(denoised(x, {.shrinkage = kRules[r]}).signal - doppler) / 2048.0;
    }
  }
  const auto [soft, hard, garrote] = risk;
  EXPECT_LT(hard, garrote);
  EXPECT_LT(garrote, soft);
  EXPECT_LT(soft, 0.5);  // the samples themselves: 1
}

/// First-order Gauss-Markov noise of unit standard deviation, correlation exp(-|lag|/time).
Signal coloured(std::size_t count, double time, std::uint64_t seed) {
  const double memory = std::exp(-1.0 / time);
  Signal values = gaussian(count, std::sqrt(1.0 - memory * memory), seed);
  values[0] /= std::sqrt(1.0 - memory * memory);
  for (std::size_t i = 1; i < count; ++i) values[i] += memory * values[i - 1];
  return values;
}

TEST(Denoise, ColouredNoiseNeedsItsLevelPerLevel) {
  const Signal noise = coloured(32768, 20.0, 8);
  DenoisingOptions options{.levels = 7};
  const Denoised finest = denoised(noise, options);
  options.noise = NoiseFrom::per_level;
  const Denoised per_level = denoised(noise, options);
  // Power grows towards low frequencies: the finest details (sigma about 0.2) promise far less noise than there is.
  EXPECT_LT(finest.sigma[0], 0.25);
  EXPECT_GT(finest.sigma[6], 10.0 * finest.sigma[0]);
  const double all = energy(noise - finest.trend);
  EXPECT_GT(energy(finest.signal - finest.trend), 0.5 * all);
  // At N/2^j samples and its own sigma a threshold is exceeded about once per level (probability 0.1 to 0.2 a level).
  EXPECT_LT(energy(per_level.signal - per_level.trend), 0.01 * all);
}

TEST(Denoise, RelaxationZeroLeavesALevelUntouched) {
  const Signal x = gaussian(4096, 1.0, 9);
  for (const Shrinkage rule : kRules) {
    DenoisingOptions options{
        .levels = 4, .boundary = Boundary::periodization, .shrinkage = rule, .relaxation = {1, 0, 1, 1}};
    const Decomposition before = decomposed(x, 4, Boundary::periodization);
    const Decomposition after = decomposed(denoised(x, options).signal, 4, Boundary::periodization);
    EXPECT_LT(largest(after.details[1] - before.details[1]), 1e-11);
    EXPECT_GT(largest(after.details[0] - before.details[0]), 1.0);
    EXPECT_GT(largest(after.details[2] - before.details[2]), 1.0);
    EXPECT_LT(largest(after.approximation - before.approximation), 1e-11);
    for (const Boundary boundary : {Boundary::symmetric, Boundary::periodization}) {
      options = {.levels = 4, .boundary = boundary, .shrinkage = rule, .relaxation = {0, 0, 0, 0}};
      EXPECT_LT(largest(denoised(x, options).signal - x), 1e-11);
    }
  }
  EXPECT_LT(largest(denoised(x, {.shrinkage = Shrinkage::none}).signal - x), 1e-11);
}

TEST(Denoise, PolynomialsBelowTheNumberOfVanishingMomentsPass) {
  constexpr std::size_t kCount = 2000;
  for (const int moments : {2, 4, 8}) {
    const std::string name = "db" + std::to_string(moments);
    const std::size_t reach = support(name, 4);
    const auto through = [&](int degree) {
      const Signal p = sampled(kCount, [&](double t) { return std::pow(2.0 * t - 1.0, degree); });
      const Denoised result = denoised(p, {.levels = 4, .threshold = 1e6}, name);
      EXPECT_LT(largest(result.signal - result.trend), 1e-12);
      return largest(part(result.signal - p, reach, kCount - reach));
    };
    // Sums of 16 rounded terms of size 1 per level and filters printed to about 12 digits.
    for (int degree = 0; degree < moments; ++degree) EXPECT_LT(through(degree), 1e-9) << name << " " << degree;
    // The first power that the wavelet sees: t^2 over 16 of 2000 samples, for db2.
    if (moments == 2) {
      EXPECT_GT(through(2), 1e-5);
    }
  }
}

TEST(Denoise, ScalesWithTheUnitToTheLastBit) {
  const Signal x = gaussian(2000, 1.0, 10) + step(2000, 700, 5.0);
  for (const Shrinkage rule : kRules) {
    const DenoisingOptions options{.shrinkage = rule, .noise = NoiseFrom::per_level};
    const Denoised one = denoised(x, options);
    for (const double unit : {0x1p40, -0x1p-30}) {
      const Denoised other = denoised(unit * x, options);
      EXPECT_EQ(other.signal, unit * one.signal);
      EXPECT_EQ(other.trend, unit * one.trend);
      EXPECT_EQ(other.thresholds, std::abs(unit) * one.thresholds);
    }
  }
}

TEST(Denoise, AnOffsetChangesNothingElse) {
  const Signal x = gaussian(2000, 1.0, 11);
  const Signal offset(2000, 100.0);
  const Denoised one = denoised(x, {.shrinkage = Shrinkage::soft});
  const Denoised other = denoised(x + offset, {.shrinkage = Shrinkage::soft});
  // Rounding at 100 and filters that sum to 0 and sqrt(2) within 1e-12: about 1e-10 after six levels. Soft shrinkage is
  // continuous, so that nothing jumps.
  EXPECT_LT(largest(other.signal - offset - one.signal), 1e-9);
  EXPECT_LT(largest(other.trend - offset - one.trend), 1e-9);
}

TEST(Denoise, TrendIsWhatRemainsAboveEveryThreshold) {
  const Signal x = gaussian(777, 1.0, 12);
  for (const Shrinkage rule : kRules) {
    const Denoised result = denoised(x, {.levels = 5, .shrinkage = rule, .threshold = 1e9});
    EXPECT_EQ(result.signal, result.trend);
  }
}

void expect_refused(const Signal& samples, const DenoisingOptions& options, const std::string& where) {
  const auto result = denoise(samples, wavelet("db2"), options);
  ASSERT_FALSE(result) << where;
  EXPECT_EQ(result.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(result.error().where, where);
}

TEST(Denoise, RefusesWhatItCannotUse) {
  const Signal x = gaussian(100, 1.0, 13);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  expect_refused(x, {.levels = 2, .relaxation = {1, 1, 1}}, "relaxation");
  expect_refused(x, {.levels = 2, .relaxation = {1, -0.5}}, "level 2");
  expect_refused(x, {.levels = 2, .relaxation = {kNan}}, "level 1");
  expect_refused(x, {.threshold = -1.0}, "threshold");
  expect_refused(x, {.threshold = kInfinity}, "threshold");
  expect_refused(x, {.levels = 0}, "levels");
  expect_refused(x, {.levels = 41}, "levels");
  expect_refused({}, {}, "");
  Signal missing = x;
  missing[17] = kNan;
  expect_refused(missing, {}, "sample 17");
}

}  // namespace
}  // namespace soak::calib::signal
