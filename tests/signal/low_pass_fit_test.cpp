// SPDX-License-Identifier: Apache-2.0
// The noise density of units that filter their own output. Records from tests/signal/filtered_noise.h, which shares
// nothing with calib.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include "calib/signal/allan/allan.h"
#include "calib/signal/allan/allan_fit.h"
#include "calib/signal/allan/detail/low_pass_curve.h"
#include "calib/signal/spectrum/low_pass.h"
#include "tests/long_tests.h"
#include "tests/signal/filtered_noise.h"

namespace soak::calib::signal {
namespace {

using filtered_noise::Record;
using filtered_noise::Unit;

struct Fitted {
  std::optional<LowPass> low_pass;
  AllanFit fit;
};

Fitted fitted(const Record& record, double rate_hz) {
  const auto phase = PhaseRecord::from_rate(record.rate, rate_hz);
  EXPECT_TRUE(phase);
  AllanCurve curve =
      overlapping_curve(*phase, log_spaced_multiples(2 * phase->longest(AllanKind::overlapping) / 3, 12));
  curve.low_pass = find_low_pass(record.rate, rate_hz);
  const auto fit = fit_allan(curve);
  EXPECT_TRUE(fit) << fit.error().message;
  return {curve.low_pass, fit ? *fit : AllanFit{}};
}

/// So many records, or as many as the proof `low-pass-coverage` asks for: 600.
std::size_t records() {
  const char* count = std::getenv("SOAK_LOW_PASS_RECORDS");
  return count == nullptr ? 48 : std::stoul(count);
}

bool is_long() { return std::getenv("SOAK_LOW_PASS_RECORDS") != nullptr; }

/// Which records: the proof can be made again on others.
std::uint64_t first_seed() {
  const char* seed = std::getenv("SOAK_LOW_PASS_SEED");
  return seed == nullptr ? 510000 : std::stoull(seed);
}

/// Twelve filters at corners from 5 to 250 Hz, sampled at 100 to 2000 Hz, half of them behind a coarse converter.
Unit drawn_unit(std::uint64_t seed) {
  constexpr std::array kRates = {100.0, 200.0, 400.0, 500.0, 1000.0, 2000.0};
  constexpr std::array kCorners = {5.0, 8.0, 15.0, 30.0, 42.0, 80.0, 120.0, 250.0};
  constexpr std::array kLengths = {300.0, 600.0, 1800.0};
  std::mt19937_64 draw(seed);
  const auto one_of = [&](const auto& list) { return list[draw() % list.size()]; };
  Unit unit;
  unit.filter = one_of(filtered_noise::filters());
  unit.rate_hz = one_of(kRates);
  unit.corner_hz = one_of(kCorners);
  unit.length_s = one_of(kLengths);
  unit.white = 0.01;
  if (draw() % 2 == 1) unit.step = 0.02;
  if (!is_long()) unit.length_s = std::min(unit.length_s, 1e5 / unit.rate_hz);
  return unit;
}

struct Tally {
  double count = 0.0, inside = 0.0, below = 0.0, invented = 0.0, corners = 0.0, near = 0.0, misfits = 0.0;
  double filters = 0.0, bias = 0.0, flicker_below = 0.0, walk_below = 0.0, markov_below = 0.0;
};

/// `with`: what the unit has beside white noise.
Tally tally(std::uint64_t block, std::size_t count, const std::function<void(Unit&)>& with) {
  Tally t;
  for (std::uint64_t i = 1; i <= count; ++i) {
    Unit unit = drawn_unit(first_seed() + 10000 * block + i);
    with(unit);
    const Record record = filtered_noise::make_record(unit, first_seed() + 100000 + 10000 * block + i);
    const auto [low_pass, fit] = fitted(record, unit.rate_hz);
    const AllanCoefficient& n = fit.angle_random_walk;
    ++t.count;
    t.inside += n.low <= record.density && record.density <= n.high;
    t.below += n.high < record.density;
    if (n.high < record.density) {
      std::printf("  upper end of N behind %s, %g Hz at %g Hz, %g s, low-pass %s: %.3f of the truth, N %.3f of it\n",
                  unit.filter.c_str(), unit.corner_hz, unit.rate_hz, unit.length_s, low_pass ? "found" : "not found",
                  n.high / record.density, n.value / record.density);
    }
    t.invented += fit.bias_instability.found || fit.flicker.found || fit.rate_random_walk.found ||
                  fit.markov_sigma.found || fit.rate_ramp.found;
    t.bias += fit.bias_instability.found;
    // The least of the curve lies on the flicker's own or above.
    t.flicker_below += fit.flicker.high < unit.flicker || fit.bias_instability.high < unit.flicker;
    t.walk_below += fit.rate_random_walk.high < unit.walk;
    t.markov_below += fit.markov_sigma.high < unit.markov_sigma;
    t.misfits += fit.p_value < 0.001;
    t.filters += low_pass.has_value();
    // Beyond 0.8 of half the rate half of the power may not be there after sampling, or only just.
    const auto half = filtered_noise::half_power_hz(unit);
    if (!half || *half > 0.4 * unit.rate_hz) continue;
    ++t.corners;
    const auto corner_hz = low_pass ? low_pass->half_power_hz() : std::nullopt;
    const bool is_near = corner_hz && std::abs(*corner_hz / *half - 1.0) < 0.1;
    t.near += is_near;
    if (!is_near) {
      std::printf("  corner of %s, %g Hz at %g Hz: %g, stated %g\n", unit.filter.c_str(), unit.corner_hz, unit.rate_hz,
                  *half, corner_hz.value_or(0.0));
    }
  }
  std::printf(
      "%.0f records: N inside %.1f %%, its upper end below the truth in %.1f %%; low-pass found in %.1f %%, corner "
      "within 10 %% in %.1f %% of %.0f; other terms found in %.1f %%, bias instability in %.1f %%, its upper end or "
      "that of flicker below the truth in %.1f %%, that of K in %.1f %%, that of the Gauss-Markov term in %.1f %%; "
      "poor fit %.1f %%\n",
      t.count, 100.0 * t.inside / t.count, 100.0 * t.below / t.count, 100.0 * t.filters / t.count,
      100.0 * t.near / std::max(1.0, t.corners), t.corners, 100.0 * t.invented / t.count, 100.0 * t.bias / t.count,
      100.0 * t.flicker_below / t.count, 100.0 * t.walk_below / t.count, 100.0 * t.markov_below / t.count,
      100.0 * t.misfits / t.count);
  return t;
}

/// A share with three standard deviations' room for the few records of the short sample, none for 500 and more.
double room(double share, double count) { return count < 500.0 ? 3.0 * std::sqrt(share * (1.0 - share) / count) : 0.0; }

/// 95 % +- 3 %; an upper end below the truth in no more than 2.5 %.
void expect_density(const Tally& t) {
  EXPECT_GE(t.inside / t.count, 0.92 - room(0.92, t.count));
  EXPECT_LE(t.inside / t.count, 0.98 + room(0.98, t.count));
  EXPECT_LE(t.below / t.count, 0.025 + room(0.025, t.count));
}

TEST(LowPassFit, IntervalsHoldTheDensityOfWhiteNoiseAndNothingElseIsFound) {
  SOAK_LONG_TEST();
  const Tally t = tally(1, records(), [](Unit&) {});
  expect_density(t);
  EXPECT_LE(t.invented / t.count, 0.025 + room(0.025, t.count));
  EXPECT_LE(t.misfits / t.count, 0.02 + room(0.02, t.count));
  EXPECT_GE(t.near / t.corners, 0.95 - room(0.95, t.corners));
}

TEST(LowPassFit, BiasInstabilityIsFoundBehindALowPass) {
  const Tally t = tally(2, records() / 3, [](Unit& unit) {
    unit.length_s = 300.0;
    unit.flicker = 0.005;
  });
  EXPECT_GE(t.inside / t.count, 0.92 - room(0.92, t.count));
  EXPECT_LE(t.below / t.count, 0.025 + room(0.025, t.count));
  EXPECT_LE(t.flicker_below / t.count, 0.025 + room(0.025, t.count));
  EXPECT_GE(t.bias / t.count, 0.8);
}

// Such a process passes for flicker as far as short averaging times show it: the noise density is then too low.
TEST(LowPassFit, AGaussMarkovProcessOfSecondsDoesNotTakeTheDensityOfWhiteNoise) {
  constexpr std::array kTimes = {1.0, 2.0, 5.0, 10.0, 20.0, 40.0};
  std::size_t number = 0;
  const Tally t = tally(4, records() / 3, [&](Unit& unit) {
    unit.length_s = 600.0;
    unit.rate_hz = std::min(unit.rate_hz, 400.0);
    unit.corner_hz = std::min(unit.corner_hz, 42.0);
    unit.markov_sigma = 0.03;  // three times N, over the root of a second
    unit.markov_s = kTimes[number++ % kTimes.size()];
  });
  EXPECT_GE(t.inside / t.count, 0.88 - room(0.88, t.count));
  EXPECT_LE(t.below / t.count, 0.06 + room(0.06, t.count));
  EXPECT_LE(t.markov_below / t.count, 0.05 + room(0.05, t.count));
}

// Its upper end is that of a term that may not be seen: the walk reaches the white noise at 43 s of a record's 300.
TEST(LowPassFit, NoUpperEndOfARandomWalkBehindALowPassLiesBelowIt) {
  SOAK_LONG_TEST();
  const Tally t = tally(5, records() / 3, [](Unit& unit) {
    unit.length_s = 300.0;
    unit.walk = 0.0004;
  });
  EXPECT_LE(t.walk_below / t.count, 0.025 + room(0.025, t.count));
  EXPECT_LE(t.below / t.count, 0.025 + room(0.025, t.count));
  EXPECT_GE(t.inside / t.count, 0.92 - room(0.92, t.count));
}

TEST(LowPassFit, WithoutAFilterNoneIsFoundAndTheDensityIsRight) {
  const Tally t = tally(3, records() / 3, [](Unit& unit) { unit.filter = ""; });
  EXPECT_GE(t.inside / t.count, 0.92 - room(0.92, t.count));
  EXPECT_LE(t.filters / t.count, 0.01);
  EXPECT_LE(t.invented / t.count, 0.025 + room(0.025, t.count));
}

TEST(LowPassFit, ARandomWalkBehindALowPassIsFound) {
  const Unit unit{
      .filter = "butter2", .corner_hz = 20.0, .rate_hz = 200.0, .length_s = 1200.0, .white = 0.01, .walk = 0.002};
  const auto [low_pass, fit] = fitted(filtered_noise::make_record(unit, 7), unit.rate_hz);
  ASSERT_TRUE(low_pass);
  EXPECT_TRUE(fit.rate_random_walk.found);
  EXPECT_LT(fit.rate_random_walk.low, unit.walk);
  EXPECT_GT(fit.rate_random_walk.high, unit.walk);
}

TEST(LowPassFit, ASlowGaussMarkovProcessIsNoLowPass) {
  const Unit unit{
      .filter = "", .rate_hz = 100.0, .length_s = 1800.0, .white = 0.01, .markov_sigma = 0.03, .markov_s = 10.0};
  const auto [low_pass, fit] = fitted(filtered_noise::make_record(unit, 8), unit.rate_hz);
  EXPECT_FALSE(low_pass);
  ASSERT_TRUE(fit.markov_sigma.found);
  // Known to about 20 % from 180 correlation times (GaussMarkovFit: 1.5 sqrt(2 T/L) = 16 %): three of these.
  EXPECT_NEAR(fit.markov_time_s.value / 10.0, 1.0, 0.5);
}

TEST(LowPassFit, OnePoleHasTheLagAndTheCurveOfItsCorrelation) {
  // r_k = c exp(-k/T) with sum_k r_k = 1: lag 2 c sum k exp(-k/T); Allan variance from the sums over r.
  constexpr double kTime = 12.0;
  const LowPass filter{.corner_hz = 1000.0 / (2.0 * std::numbers::pi * kTime), .rate_hz = 1000.0, .order = 1};
  const double e = std::exp(-1.0 / kTime);
  const double c = (1.0 - e) / (1.0 + e);
  const allan_fit::LowPassCurve curve(filter, 1e-3);
  // Three foldings to each side leave a tail of the density out: 3 % of the variance from sample to sample.
  EXPECT_NEAR(curve.lag() / (2.0 * c * e / std::pow(1.0 - e, 2)), 1.0, 0.01);
  for (const int m : {1, 5, 40, 300}) {
    double variance = 0.0;  // of (sum of m samples - sum of the next m)/m
    for (int i = -2 * m; i <= 2 * m; ++i) {
      const int a = std::abs(i);
      const double overlap = a < m ? 2.0 * (m - a) - a : a < 2 * m ? -(2.0 * m - a) : 0.0;
      variance += overlap * c * std::pow(e, a);
    }
    variance /= 2.0 * m * m;
    EXPECT_NEAR(curve.at(m, 1e5).variance / variance, 1.0, m == 1 ? 0.04 : 0.01) << m;
  }
  EXPECT_NEAR(curve.at(1000.0, 1e5).variance, 1e-3 - 1.5 * curve.lag() * 1e-6, 1e-6);
}

TEST(LowPassFit, WhereTheRecordEndsWithinTheLowPassItIsRefused) {
  AllanCurve curve{0.001, {301}, {1, 2, 4, 8, 16, 32, 64, 100}, {8, 8, 8, 7, 6, 5, 4, 3}, {}};
  EXPECT_TRUE(fit_allan(curve));
  curve.low_pass = LowPass{.corner_hz = 10.0, .rate_hz = 1000.0};
  EXPECT_FALSE(fit_allan(curve));
}

/// A real Xsens MTi at rest for 49 s, 100 Hz, in counts: its filter lets half of the band through, so that only the
/// last octave shows it. White noise beyond: at 0.5 s the curve itself shows N, with some 130 degrees of freedom (6 %).
TEST(LowPassFit, DensityOfARealUnitIsThatOfItsCurveBeyondTheFilter) {
  const char* folder = std::getenv("SOAK_TEST_DATA");
  const std::filesystem::path data = folder != nullptr && *folder != '\0'
                                         ? std::filesystem::path(folder)
                                         : std::filesystem::path(SOAK_TEST_FOLDER) / ".." / ".." / "shared" / "data";
  for (const char* name : {"xsens_gyro.mat", "xsens_acc.mat"}) {
    std::ifstream file(data / "multi_position_xsens" / name);
    if (!file) GTEST_SKIP() << "no recordings at " << data;
    std::array<Record, 3> axes;
    double t_s = 0.0, first_s = -1.0;
    for (std::array<double, 3> row{}; file >> t_s >> row[0] >> row[1] >> row[2];) {
      if (first_s < 0.0) first_s = t_s;
      for (std::size_t k = 0; k < 3 && t_s - first_s > 1.0 && t_s - first_s < 50.0; ++k) {
        axes[k].rate.push_back(row[k]);
      }
    }
    for (const Record& axis : axes) {
      ASSERT_GT(axis.rate.size(), 4800U);
      const auto [low_pass, fit] = fitted(axis, 100.0);
      EXPECT_TRUE(low_pass) << name;
      EXPECT_FALSE(fit.markov_sigma.found) << name;
      EXPECT_GT(fit.p_value, 0.001) << name;
      ASSERT_TRUE(fit.angle_random_walk.found) << name;
      const auto phase = PhaseRecord::from_rate(axis.rate, 100.0);
      const double at_half_s = allan_point(*phase, AllanKind::overlapping, 50).deviation * std::sqrt(0.5);
      EXPECT_NEAR(fit.angle_random_walk.value / at_half_s, 1.0, 0.18) << name;
    }
  }
}

TEST(LowPassFit, NothingIsFoundInRecordsWithoutASpectrum) {
  EXPECT_FALSE(find_low_pass({}, 100.0));
  EXPECT_FALSE(find_low_pass(std::vector<double>(100, 1.0), 100.0));
  EXPECT_FALSE(find_low_pass(std::vector<double>(100000, 1.0), 100.0)) << "a stuck sensor";
  EXPECT_FALSE(find_low_pass(std::vector<double>(100000, std::nan("")), 100.0));
}

}  // namespace
}  // namespace soak::calib::signal
