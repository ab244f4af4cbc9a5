// SPDX-License-Identifier: Apache-2.0
// The fit to an Allan deviation: terms, units, refusals, a real oscillator.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "calib/signal/allan/allan.h"
#include "calib/signal/allan/allan_fit.h"
#include "calib/signal/noise/noise.h"
#include "tests/signal/allan_fit_support.h"

namespace soak::calib::signal {
namespace {

using namespace allan_fit_support;

AllanFit fit_of(const Samples& rate, double rate_hz = 1.0) {
  const auto fit = fit_allan(curve_of(rate, rate_hz));
  EXPECT_TRUE(fit) << fit.error().message;
  return *fit;
}

TEST(AllanFit, NoAbsentTermMayRiseAboveTheCurve) {
  const AllanCurve curve = curve_with_a_line();
  const auto fit = fit_allan(curve);
  ASSERT_TRUE(fit);
  for (std::size_t i = 0; i < curve.multiples.size(); ++i) {
    const double tau = static_cast<double>(curve.multiples[i]) * curve.interval_s;
    const double most = fit->ci95[i][1] * (1.0 + 1e-9);
    EXPECT_LE(fit->angle_random_walk.high / std::sqrt(tau), most);
    EXPECT_LE(fit->flicker.high * std::sqrt(2.0 * std::numbers::ln2 / std::numbers::pi), most);
    EXPECT_LE(fit->rate_random_walk.high * std::sqrt(tau / 3.0), most);
    EXPECT_LE(fit->rate_ramp.high * tau / std::sqrt(2.0), most);
    EXPECT_LE(fit->bias_instability.high * std::sqrt(2.0 * std::numbers::ln2 / std::numbers::pi), most);
  }
}

TEST(AllanFit, AnAbsentMarkovTermHasAnUpperLimitAndNoTime) {
  const AllanCurve curve = curve_of(white_noise(8192, 1.0, {.rate_hz = 1.0, .seed = 22}));
  const auto fit = fit_allan(curve);
  ASSERT_TRUE(fit);
  ASSERT_FALSE(fit->markov_sigma.found);
  EXPECT_EQ(fit->markov_sigma.low, 0.0);
  EXPECT_TRUE(std::isinf(fit->markov_time_s.high));
  // The largest sigma whose curve, 2 sigma^2 T/m (1 - T/(2 m) (3 - 4 exp(-m/T) + exp(-2 m/T))) [IEEE 952], stays below
  // the upper limits: for each time by the tightest averaging time, then the largest. A grid of times 1 % apart against
  // one of 20 %: sigma changes by less than half of the step.
  double largest = 0.0;
  for (double t = 1.0; t <= static_cast<double>(curve.multiples.back()); t *= 1.01) {
    double least = 1e300;
    for (std::size_t i = 0; i < curve.multiples.size(); ++i) {
      const double x = t / static_cast<double>(curve.multiples[i]);
      const double phi = 2.0 * x * (1.0 - 0.5 * x * (3.0 - 4.0 * std::exp(-1.0 / x) + std::exp(-2.0 / x)));
      least = std::min(least, fit->ci95[i][1] / std::sqrt(phi));
    }
    largest = std::max(largest, least);
  }
  EXPECT_NEAR(fit->markov_sigma.high / largest, 1.0, 0.1);
}

TEST(AllanFit, AnyUnitGivesTheSameFit) {
  const AllanCurve curve = curve_of(noise_of(truth_of(1.0, 0.3, 0.02), 8192, 23));
  const auto plain = fit_allan(curve);
  ASSERT_TRUE(plain);
  for (const double unit : {1e-250, 1e-100, 1e-30, 1e90, 1e250}) {
    AllanCurve other = curve;
    for (double& deviation : other.deviation) deviation *= unit;
    const auto fit = fit_allan(other);
    ASSERT_TRUE(fit) << unit;
    // The curve is scaled by a number that rounds differently: 1e-16, times the condition of the fit.
    EXPECT_NEAR(fit->angle_random_walk.value / unit / plain->angle_random_walk.value, 1.0, 1e-6) << unit;
    EXPECT_NEAR(fit->flicker.high / unit / plain->flicker.high, 1.0, 1e-6) << unit;
    EXPECT_NEAR(fit->ci95[3][1] / unit / plain->ci95[3][1], 1.0, 1e-6) << unit;
  }
}

TEST(AllanFit, CurvesThatNoDoubleCanHoldAreRefused) {
  AllanCurve curve{1.0, {1001}, {1, 2, 4, 8, 16}, {1e-320, 7e-321, 5e-321, 3e-321, 2e-321}};
  EXPECT_FALSE(fit_allan(curve)) << "numbers without their full precision";
  curve.deviation = {1e308, 0.7e308, 0.5e308, 0.35e308, 0.25e308};
  curve.interval_s = 1e6;
  EXPECT_FALSE(fit_allan(curve)) << "N = 1e308 sqrt(1e6)";
  curve.deviation = {1e-300, 1e300, 1e-300, 1e300, 1e-300};
  curve.interval_s = 1.0;
  EXPECT_FALSE(fit_allan(curve)) << "squares 1e1200 apart";
}

TEST(AllanFit, CurvesOfTheThreeNoisesHaveTheSlopesOfTheTheory) {
  const NoiseSource source{.rate_hz = 1.0, .seed = 3};
  const auto slope = [](const Samples& rate) {
    const AllanCurve curve = curve_of(rate);
    std::size_t last = 0;
    while (curve.multiples[last] < 64) ++last;
    return std::log(curve.deviation[last] / curve.deviation[0]) / std::log(static_cast<double>(curve.multiples[last]));
  };
  // At m = 64 of 65536 the deviation has some 1000 degrees of freedom: sigma 2.2 %, of the slope 0.022/ln 64 = 0.005.
  EXPECT_NEAR(slope(white_noise(65536, 1.0, source)), -0.5, 0.02);
  EXPECT_NEAR(slope(flicker_noise(65536, 1.0, source)), 0.0, 0.02);
  EXPECT_NEAR(slope(random_walk(65536, 1.0, source)), 0.5, 0.02);
}

TEST(AllanFit, CoefficientsCarryTheUnitsOfTheRate) {
  const NoiseSource source{.rate_hz = 200.0, .seed = 5};
  const Samples white = white_noise(60000, 0.01, source);
  const AllanFit fit = fit_of(white + quantization_noise(60000, 2e-3, source), 200.0);
  EXPECT_TRUE(holds(fit.angle_random_walk, 0.01)) << fit.angle_random_walk.value;
  EXPECT_TRUE(holds(fit.quantization, 2e-3)) << fit.quantization.value;
  // Stated half-widths are a few percent.
  EXPECT_NEAR(fit.angle_random_walk.value, 0.01, 0.001);
  EXPECT_NEAR(fit.quantization.value, 2e-3, 0.1e-3);
}

TEST(AllanFit, FindsARamp) {
  const NoiseSource source{.rate_hz = 10.0, .seed = 4};
  const AllanFit fit = fit_of(white_noise(16384, 1.0, source) + rate_ramp(16384, 0.02, 10.0), 10.0);
  ASSERT_TRUE(fit.rate_ramp.found);
  EXPECT_TRUE(holds(fit.rate_ramp, 0.02)) << fit.rate_ramp.value;
  EXPECT_NEAR(fit.rate_ramp.value, 0.02, 0.001);
  EXPECT_FALSE(fit.rate_random_walk.found);
}

TEST(AllanFit, FindsAMarkovTermWithItsTime) {
  const NoiseSource source{.rate_hz = 10.0, .seed = 4};
  const AllanFit fit = fit_of(white_noise(16384, 0.3, source) + gauss_markov_noise(16384, 0.5, 10.0, source), 10.0);
  ASSERT_TRUE(fit.markov_sigma.found);
  EXPECT_TRUE(holds(fit.markov_sigma, 0.5)) << fit.markov_sigma.value;
  EXPECT_TRUE(holds(fit.markov_time_s, 10.0)) << fit.markov_time_s.value;
  EXPECT_TRUE(holds(fit.angle_random_walk, 0.3)) << fit.angle_random_walk.value;
}

TEST(AllanFit, AVibrationLineShowsInTheProbabilityAndHardlyMovesTheWhiteNoise) {
  const NoiseSource source{.rate_hz = 1.0, .seed = 6};
  Samples rate = white_noise(16384, 1.0, source);
  for (std::size_t i = 0; i < rate.size(); ++i) {
    rate[i] += 0.3 * std::sin(2.0 * std::numbers::pi * 0.05 * static_cast<double>(i));
  }
  const AllanFit fit = fit_of(rate);
  EXPECT_LT(fit.p_value, 1e-6);
  // At tau = 7.4 s, where it is largest, the line has 44 % of the white noise's variance. Bound: 4 %.
  EXPECT_NEAR(fit.angle_random_walk.value, 1.0, 0.04);
}

TEST(AllanFit, PureNoiseIsRarelyCalledAMisfit) {
  int misfits = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    misfits += fit_of(white_noise(4096, 1.0, {.rate_hz = 1.0, .seed = seed})).p_value < 0.01;
  }
  EXPECT_LE(misfits, 4);  // 0.5 expected; the tails of Allan variances at long times are heavier than normal
}

TEST(AllanFit, StretchesBetweenGapsArePooled) {
  const NoiseSource source{.rate_hz = 1.0, .seed = 8};
  Samples rate = white_noise(20000, 1.0, source) + flicker_noise(20000, 0.3, source);
  for (std::size_t i = 4000; i < 20000; i += 4000) {
    for (std::size_t k = 0; k < 50; ++k) rate[i + k] = std::nan("");
  }
  const AllanCurve curve = curve_of(rate);
  ASSERT_EQ(curve.stretches.size(), 5U);
  const auto fit = fit_allan(curve);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(holds(fit->angle_random_walk, 1.0)) << fit->angle_random_walk.value;
  EXPECT_TRUE(holds(fit->flicker, 0.3)) << fit->flicker.value;
  // Five stretches of 4000 know the deviation at m = 1 as well as one of 20000: edf = 2/3 of the samples.
  EXPECT_NEAR(fit->degrees_of_freedom[0] / (2.0 / 3.0 * 19750.0), 1.0, 0.1);
}

TEST(AllanFit, WhiteNoiseAloneLeavesTheBiasInstabilityAsABound) {
  const AllanFit fit = fit_of(white_noise(8192, 1.0, {.rate_hz = 1.0, .seed = 12}));
  EXPECT_FALSE(fit.bias_instability.found);
  EXPECT_EQ(fit.bias_instability.low, 0.0);
  EXPECT_FALSE(fit.flicker.found);
  EXPECT_EQ(fit.flicker.value, 0.0);
  EXPECT_GT(fit.flicker.high, 0.0);
  EXPECT_LT(fit.flicker.high, fit.bias_instability.high + 0.1);
}

TEST(AllanFit, BiasInstabilityOfFlickerIsItsCoefficient) {
  const AllanFit fit = fit_of(flicker_noise(16384, 2.0, {.rate_hz = 1.0, .seed = 13}));
  ASSERT_TRUE(fit.bias_instability.found);
  EXPECT_TRUE(holds(fit.bias_instability, 2.0)) << fit.bias_instability.value;
}

TEST(AllanFit, FitsTheShortTimesOfARealOscillatorAndReportsTheMisfit) {
  const char* folder = std::getenv("SOAK_TEST_DATA");
  const std::filesystem::path data = folder != nullptr && *folder != '\0'
                                         ? std::filesystem::path(folder)
                                         : std::filesystem::path(SOAK_TEST_FOLDER) / ".." / ".." / "shared" / "data";
  std::ifstream file(data / "allan_stable32" / "ocxo" / "ocxo_frequency.txt");
  if (!file) GTEST_SKIP() << "no recordings at " << data;
  Samples rate;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line[0] != '#') rate.push_back(std::stod(line) / 1e7 - 1.0);
  }
  ASSERT_EQ(rate.size(), 19982U);
  const AllanCurve curve = curve_of(rate);
  const auto fit = fit_allan(curve);
  ASSERT_TRUE(fit);
  // The clean part. Beyond 300 s the curve rises threefold at fewer than 50 degrees of freedom; the fit leaves this
  // rise out (the misfit at short times, 5 % at 10,000 degrees of freedom, has inflated all variances) and must say so:
  // the misfit shows, and the random walk that would make the rise, K = sigma sqrt(3/tau), lies below the stated limit.
  for (std::size_t i = 0; i < curve.multiples.size() && curve.multiples[i] <= 300; ++i) {
    EXPECT_NEAR(fit->deviation[i] / curve.deviation[i], 1.0, 0.25) << curve.multiples[i];
  }
  EXPECT_LT(fit->p_value, 1e-6);
  const double rise = curve.deviation.back() * std::sqrt(3.0 / static_cast<double>(curve.multiples.back()));
  EXPECT_GT(fit->rate_random_walk.high, rise);
  EXPECT_LT(fit->bias_instability.high, 2.0 * fit->bias_instability.value);
  for (std::size_t i = 0; i < curve.multiples.size(); ++i) {
    EXPECT_LT(fit->ci95[i][0], curve.deviation[i]);
    EXPECT_GT(fit->ci95[i][1], curve.deviation[i]);
  }
}

TEST(AllanFit, RefusesWhatIsNoCurve) {
  const AllanCurve good{1.0, {1001}, {1, 2, 4, 8, 16}, {1.0, 0.7, 0.5, 0.35, 0.25}};
  EXPECT_TRUE(fit_allan(good));
  const auto refused = [](const AllanCurve& curve) { return !fit_allan(curve); };
  AllanCurve curve = good;
  curve.multiples.pop_back();
  EXPECT_TRUE(refused(curve));
  curve.deviation.pop_back();
  EXPECT_TRUE(refused(curve)) << "four averaging times";
  curve = good;
  curve.deviation[2] = 0.0;
  EXPECT_TRUE(refused(curve));
  curve.deviation[2] = std::nan("");
  EXPECT_TRUE(refused(curve));
  curve = good;
  curve.multiples[4] = 501;
  EXPECT_TRUE(refused(curve)) << "no difference at 501 of 1001 points";
  curve = good;
  curve.multiples[1] = 1;
  EXPECT_TRUE(refused(curve));
  curve = good;
  curve.interval_s = 0.0;
  EXPECT_TRUE(refused(curve));
  curve = good;
  curve.stretches.clear();
  EXPECT_TRUE(refused(curve));
}

}  // namespace
}  // namespace soak::calib::signal
