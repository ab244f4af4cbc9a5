// SPDX-License-Identifier: Apache-2.0
// The intervals of the fit hold the truth as often as they say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "calib/signal/allan/allan.h"
#include "calib/signal/allan/allan_fit.h"
#include "calib/signal/noise/noise.h"
#include "tests/long_tests.h"
#include "tests/signal/allan_fit_support.h"

namespace soak::calib::signal {
namespace {

using namespace allan_fit_support;

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
  SOAK_LONG_TEST();
  const Coverages c = coverages(truth_of(0.0, 1.0, 0.0), 8192, 2);
  expect_coverage(c.flicker, "flicker");
  expect_coverage(c.bias, "bias instability of flicker");
  c.curve.expect("flicker");
}

TEST(AllanFit, IntervalsHoldTheTruthInARandomWalk) {
  SOAK_LONG_TEST();
  const Coverages c = coverages(truth_of(0.0, 0.0, 1.0), 8192, 3);
  expect_coverage(c.walk, "random walk");
  c.curve.expect("random walk");
}

TEST(AllanFit, IntervalsHoldTheTruthInTheMixtureOfAMemsGyro) {
  SOAK_LONG_TEST();
  const Coverages c = coverages(truth_of(1.0, 0.3, 0.02), 16384, 4);
  expect_coverage(c.white, "white in the mixture");
  expect_coverage(c.flicker, "flicker in the mixture");
  expect_coverage(c.walk, "random walk in the mixture");
  expect_coverage(c.bias, "bias instability of the mixture");
  c.curve.expect("the mixture");
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

}  // namespace
}  // namespace soak::calib::signal
