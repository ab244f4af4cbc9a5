// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "calib/signal/allan.h"
#include "calib/signal/noise.h"

namespace soak::calib::signal {
namespace {

using Samples = std::vector<double>;

Samples operator+(Samples a, const Samples& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

/// On the averaging times that `soak signal allan` prints.
AllanCurve curve_of(const Samples& rate, double rate_hz = 1.0) {
  const auto record = PhaseRecord::from_rate(rate, rate_hz);
  EXPECT_TRUE(record);
  AllanCurve curve{.interval_s = record->interval_s()};
  for (const Stretch& stretch : record->stretches()) curve.stretches.push_back(stretch.count);
  curve.multiples = log_spaced_multiples(2 * record->longest(AllanKind::overlapping) / 3, 12);
  for (const AllanPoint& point : allan_points(*record, AllanKind::overlapping, curve.multiples)) {
    curve.deviation.push_back(point.deviation);
  }
  return curve;
}

AllanFit fit_of(const Samples& rate, double rate_hz = 1.0) {
  const auto fit = fit_allan(curve_of(rate, rate_hz));
  EXPECT_TRUE(fit) << fit.error().message;
  return *fit;
}

bool holds(const AllanCoefficient& coefficient, double truth) {
  return coefficient.low <= truth && truth <= coefficient.high;
}

/// So many records, or as many as the proof `allan-coverage` asks for: 400.
std::size_t coverage_records() {
  const char* seeds = std::getenv("SOAK_ALLAN_SEEDS");
  return seeds == nullptr ? 80 : std::stoul(seeds);
}

/// How often an interval held the truth, and how often it would have if it were half as wide.
struct Coverage {
  std::size_t records = 0;
  std::size_t inside = 0;
  std::size_t inside_half = 0;

  void add(const AllanCoefficient& c, double truth) {
    ++records;
    inside += holds(c, truth);
    inside_half += std::abs(truth - c.value) < 0.5 * (truth < c.value ? c.value - c.low : c.high - c.value);
  }
};

/// The rule, fixed before these seeds were drawn for the first time (and to be kept: a block of seeds that fails is a
/// finding, not a bad draw): the share must be 95 % +- 3 % (the demand), widened, for fewer than 400 records,
/// by twice its own scatter sqrt(p (1 - p)/n). Of 80 records all may then hold the truth; there, too wide intervals
/// show in their halves: half of 95 %, 1.96 sigma, holds 67 %, half of 98 %, 2.33 sigma, 75.6 % of normal errors. (Not
/// so of 400: there the share itself has two bounds, and intervals over several models have longer tails than normal
/// ones: those of white noise in the mixture held 95.5 %, their halves 76.8 %.)
void expect_coverage(const Coverage& c, const char* name) {
  const auto n = static_cast<double>(c.records);
  const double share = static_cast<double>(c.inside) / n;
  const double half = static_cast<double>(c.inside_half) / n;
  const auto chance = [&](double p) { return c.records < 400 ? 2.0 * std::sqrt(p * (1.0 - p) / n) : 0.0; };
  std::printf("%s: %zu of %zu intervals hold the truth, %.1f %%; their halves %.1f %%\n", name, c.inside, c.records,
              100.0 * share, 100.0 * half);
  EXPECT_GE(share, 0.92 - chance(0.92)) << name;
  EXPECT_LE(share, 0.98 + chance(0.98)) << name;
  if (c.records < 400) {
    EXPECT_LE(half, 0.756 + chance(0.756)) << name;
  }
}

/// Coverage at each averaging time. In the mean as above; at any one of some 40 down to 90 % (chi-squared stands in for
/// a quadratic form of few degrees of freedom), less three times its own scatter.
class CurveCoverage {
 public:
  void add(const AllanCurve& curve, const AllanFit& fit, const AllanFit& truth) {
    inside_.resize(curve.multiples.size(), 0);
    ++records_;
    for (std::size_t i = 0; i < inside_.size(); ++i) {
      const double deviation = std::sqrt(variance(truth, static_cast<double>(curve.multiples[i])));
      inside_[i] += fit.ci95[i][0] <= deviation && deviation <= fit.ci95[i][1];
    }
  }

  void expect(const char* name) const {
    const auto n = static_cast<double>(records_);
    const auto [least, most] = std::minmax_element(inside_.begin(), inside_.end());
    double mean = 0.0;
    for (const std::size_t inside : inside_)
      mean += static_cast<double>(inside) / n / static_cast<double>(inside_.size());
    std::printf("ci95 of the curve, %s: %.1f %% to %.1f %%, %.1f %% in the mean\n", name,
                100.0 * static_cast<double>(*least) / n, 100.0 * static_cast<double>(*most) / n, 100.0 * mean);
    EXPECT_GE(mean, 0.92 - (records_ < 400 ? 2.0 * std::sqrt(0.92 * 0.08 / n) : 0.0)) << name;
    EXPECT_LE(mean, 0.98) << name;
    EXPECT_GE(static_cast<double>(*least) / n, 0.90 - 3.0 * std::sqrt(0.90 * 0.10 / n)) << name;
  }

  /// Of the coefficients in `truth` at averaging time m s.
  static double variance(const AllanFit& truth, double m) {
    const double n = truth.angle_random_walk.value;
    const double b = truth.flicker.value;
    const double k = truth.rate_random_walk.value;
    return n * n / m + 2.0 * std::numbers::ln2 / std::numbers::pi * b * b + k * k * m / 3.0;
  }

 private:
  std::size_t records_ = 0;
  std::vector<std::size_t> inside_;
};

AllanFit truth_of(double white, double flicker, double walk) {
  AllanFit truth;
  truth.angle_random_walk.value = white;
  truth.flicker.value = flicker;
  truth.rate_random_walk.value = walk;
  return truth;
}

Samples noise_of(const AllanFit& truth, std::size_t count, std::uint64_t seed) {
  const NoiseSource source{.rate_hz = 1.0, .seed = seed};
  return white_noise(count, truth.angle_random_walk.value, source) + flicker_noise(count, truth.flicker.value, source) +
         random_walk(count, truth.rate_random_walk.value, source);
}

/// What the bias instability is to be for this truth on these averaging times.
double least_truth(const AllanFit& truth, const AllanCurve& curve) {
  double least = CurveCoverage::variance(truth, 1.0);
  for (const std::size_t m : curve.multiples) {
    least = std::min(least, CurveCoverage::variance(truth, static_cast<double>(m)));
  }
  return std::sqrt(least / (2.0 * std::numbers::ln2 / std::numbers::pi));
}

struct Coverages {
  Coverage white, flicker, walk, bias;
  CurveCoverage curve;
};

/// Seeds from 410001 on: used for nothing else.
Coverages coverages(const AllanFit& truth, std::size_t count, std::uint64_t block) {
  Coverages c;
  for (std::size_t seed = 1; seed <= coverage_records(); ++seed) {
    const AllanCurve curve = curve_of(noise_of(truth, count, 400000 + 10000 * block + seed));
    const auto fit = fit_allan(curve);
    EXPECT_TRUE(fit);
    if (!fit) continue;
    c.white.add(fit->angle_random_walk, truth.angle_random_walk.value);
    c.flicker.add(fit->flicker, truth.flicker.value);
    c.walk.add(fit->rate_random_walk, truth.rate_random_walk.value);
    c.bias.add(fit->bias_instability, least_truth(truth, curve));
    c.curve.add(curve, *fit, truth);
  }
  return c;
}

TEST(AllanFit, IntervalsHoldTheTruthInWhiteNoise) {
  const Coverages c = coverages(truth_of(1.0, 0.0, 0.0), 8192, 1);
  expect_coverage(c.white, "white");
  c.curve.expect("white");
}

TEST(AllanFit, IntervalsHoldTheTruthInFlickerNoise) {
  const Coverages c = coverages(truth_of(0.0, 1.0, 0.0), 8192, 2);
  expect_coverage(c.flicker, "flicker");
  expect_coverage(c.bias, "bias instability of flicker");
  c.curve.expect("flicker");
}

TEST(AllanFit, IntervalsHoldTheTruthInARandomWalk) {
  const Coverages c = coverages(truth_of(0.0, 0.0, 1.0), 8192, 3);
  expect_coverage(c.walk, "random walk");
  c.curve.expect("random walk");
}

TEST(AllanFit, IntervalsHoldTheTruthInTheMixtureOfAMemsGyro) {
  const Coverages c = coverages(truth_of(1.0, 0.3, 0.02), 16384, 4);
  expect_coverage(c.white, "white in the mixture");
  expect_coverage(c.flicker, "flicker in the mixture");
  expect_coverage(c.walk, "random walk in the mixture");
  expect_coverage(c.bias, "bias instability of the mixture");
  c.curve.expect("the mixture");
}

/// White noise with a line a hundred times above it in variance.
AllanCurve curve_with_a_line() {
  Samples rate = white_noise(40000, 0.1 / std::sqrt(200.0), {.rate_hz = 200.0, .seed = 21});
  for (std::size_t i = 0; i < rate.size(); ++i) {
    rate[i] += std::sin(2.0 * std::numbers::pi * 17.3 / 200.0 * static_cast<double>(i));
  }
  return curve_of(rate, 200.0);
}

TEST(AllanFit, IntervalsOfACurveThatMisfitsAreNoNarrowerThanWhiteNoiseGivesThem) {
  const AllanCurve curve = curve_with_a_line();
  const auto fit = fit_allan(curve);
  ASSERT_TRUE(fit);
  ASSERT_LT(fit->p_value, 1e-6);
  constexpr double kPoints = 40001.0;
  for (std::size_t i = 0; i < curve.multiples.size(); ++i) {
    const auto m = static_cast<double>(curve.multiples[i]);
    // NIST SP 1065, white FM, good to 6 % (AllanCovariance.WhiteNoiseHasThePublishedDegreesOfFreedom), below m = n/4.
    const double white =
        (3.0 * (kPoints - 1.0) / (2.0 * m) - 2.0 * (kPoints - 2.0) / kPoints) * (4.0 * m * m) / (4.0 * m * m + 5.0);
    if (4.0 * m < kPoints) {
      EXPECT_LT(fit->degrees_of_freedom[i], 1.06 * white) << m;
    }
    EXPECT_GE(fit->degrees_of_freedom[i], 1.0) << m;
    // Where the fitted curve lies far below the measured one, the interval is as wide as that.
    if (fit->deviation[i] < 0.1 * curve.deviation[i]) {
      EXPECT_LT(fit->degrees_of_freedom[i], 2.1) << m;
    }
  }
  EXPECT_LT(fit->degrees_of_freedom.back(), 2.7);
  EXPECT_GT(fit->ci95.back()[1], 2.0 * curve.deviation.back());
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
