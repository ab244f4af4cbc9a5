// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/allan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "allan_reference.h"

namespace soak::calib::signal {
namespace {

using test::allan_by_definition;
using test::gaussian_noise;
using test::kAllKinds;
using test::kMissing;
using test::make_gaps;

PhaseRecord record_of(const std::vector<double>& rate, std::size_t bridge = PhaseRecord::kBridge) {
  auto record = PhaseRecord::from_rate(rate, 1.0, bridge);
  EXPECT_TRUE(record) << record.error().message;
  return *record;
}

std::vector<std::size_t> all_multiples(std::size_t longest) {
  std::vector<std::size_t> multiples(longest);
  std::iota(multiples.begin(), multiples.end(), std::size_t{1});
  return multiples;
}

std::vector<double> running_sum(const std::vector<double>& values) {
  std::vector<double> sums(values.size());
  std::partial_sum(values.begin(), values.end(), sums.begin());
  return sums;
}

void expect_definition(const std::vector<double>& rate, AllanKind kind, std::size_t bridge) {
  const PhaseRecord record = record_of(rate, bridge);
  const auto stretches = test::stretches_without_gap(rate, bridge);
  const std::size_t longest = record.longest(kind);
  // One beyond the longest too: no terms there.
  for (const AllanPoint& point : allan_points(record, kind, all_multiples(longest + 1))) {
    const AllanPoint expected = allan_by_definition(stretches, kind, point.multiple);
    ASSERT_EQ(point.terms, expected.terms) << point.multiple;
    ASSERT_EQ(point.terms == 0, point.multiple > longest);
    if (point.terms == 0) {
      EXPECT_TRUE(std::isnan(point.deviation));
    } else {
      // At most 150 samples of magnitude 1: phase below 100, known to 1e-14; differences of magnitude 1.
      EXPECT_NEAR(point.deviation / expected.deviation, 1.0, 1e-12) << point.multiple;
    }
  }
}

TEST(Allan, EveryKindIsItsDefinitionOnRecordsWithoutGaps) {
  for (const AllanKind kind : kAllKinds) {
    for (const std::size_t count : {2U, 3U, 7U, 50U, 150U}) expect_definition(gaussian_noise(count, count), kind, 0);
  }
}

TEST(Allan, EveryKindIsItsDefinitionOnRecordsWithGaps) {
  for (const AllanKind kind : kAllKinds) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      std::vector<double> rate = gaussian_noise(120, seed);
      make_gaps(rate, 25, 4, seed);
      for (const std::size_t bridge : {0U, 2U, 5U}) expect_definition(rate, kind, bridge);
    }
  }
}

/// Modified Allan deviation by cumulative sums of second differences in extended precision: the definition in means of
/// the rate would take minutes.
double modified_in_extended_precision(const std::vector<double>& rate, std::size_t m) {
  std::vector<long double> phase = {0.0L};
  for (const double r : rate) phase.push_back(phase.back() + (r - rate.front()));
  std::vector<long double> cumulative = {0.0L};
  for (std::size_t i = 0; i + 2 * m < phase.size(); ++i) {
    cumulative.push_back(cumulative.back() + (phase[i + 2 * m] - 2 * phase[i + m] + phase[i]));
  }
  long double squares = 0.0L;
  for (std::size_t i = 0; i + m < cumulative.size(); ++i) {
    const long double window = cumulative[i + m] - cumulative[i];
    squares += window * window;
  }
  const auto length = static_cast<long double>(m);
  const auto terms = static_cast<long double>(cumulative.size() - m);
  return static_cast<double>(std::sqrt(squares / (2.0L * terms)) / (length * length));
}

TEST(Allan, WindowsLongerThanABlockAreTheirDefinition) {
  // Random walk; blocks of 4096 beginnings, windows of more than that in blocks of their own. kernels.h: at most m/8
  // additions of random sign with 2^-53 each: 1e-14; the phase (1e6, its differences 1e5): 1e-15.
  const std::vector<double> rate = running_sum(gaussian_noise(13000, 3));
  const PhaseRecord record = record_of(rate);
  for (const std::size_t m : {3U, 1000U, 4096U, 4097U, 4200U}) {
    const AllanPoint point = allan_point(record, AllanKind::modified, m);
    EXPECT_EQ(point.terms, 13001 - 3 * m + 1);
    EXPECT_NEAR(point.deviation / modified_in_extended_precision(rate, m), 1.0, 1e-12) << m;
  }
}

TEST(Allan, SeveralMultiplesAtOnceGiveTheBitsOfEachAlone) {
  std::vector<double> rate = gaussian_noise(40000, 4);
  make_gaps(rate, 9000, 40, 4);
  const PhaseRecord record = record_of(rate);
  const std::vector<std::size_t> multiples = {1, 2, 3, 17, 500, 4095, 4096, 4097, 5000, 6000, 0, 2, 100000};
  for (const AllanKind kind : kAllKinds) {
    const std::vector<AllanPoint> together = allan_points(record, kind, multiples);
    ASSERT_EQ(together.size(), multiples.size());
    for (std::size_t k = 0; k < multiples.size(); ++k) {
      const AllanPoint alone = allan_point(record, kind, multiples[k]);
      EXPECT_EQ(together[k].multiple, multiples[k]);
      EXPECT_EQ(together[k].terms, alone.terms);
      EXPECT_TRUE(test::same_value(together[k].deviation, alone.deviation)) << multiples[k];
    }
    EXPECT_EQ(together[10].terms, 0U);
    EXPECT_TRUE(std::isnan(together[12].deviation));
  }
}

TEST(Allan, OffsetChangesNoBitWhereTheSamplesCanHoldIt) {
  // Noise in steps of 2^-23 below 16 stays exact beside 1e9 (53 bits: steps of 2^-23 below 2^30).
  std::vector<double> rate = gaussian_noise(20000, 5);
  for (double& r : rate) r = std::ldexp(std::round(std::ldexp(r, 23)), -23);
  std::vector<double> offset = rate;
  for (double& r : offset) r += 1e9;
  for (const AllanKind kind : kAllKinds) {
    for (const std::size_t m : {1U, 10U, 1000U, 6000U}) {
      EXPECT_EQ(allan_point(record_of(offset), kind, m).deviation, allan_point(record_of(rate), kind, m).deviation);
    }
  }
}

TEST(Allan, OffsetOf1e9OnNoiseOf1CostsOnlyTheRoundingOfTheSamples) {
  // Samples beside 1e9 are rounded to 2^-23: white noise of r = 2^-23/sqrt(12) = 3.4e-8 on that of 1. Every deviation
  // is the length of a vector that is linear in the samples, so it changes by at most that of the rounding alone: r
  // times the same deviation, but for the chance in both with 17 terms or more, for which a factor of 2 allows.
  const std::vector<double> rate = gaussian_noise(20000, 6);
  std::vector<double> offset = rate;
  for (double& r : offset) r += 1e9;
  for (const AllanKind kind : kAllKinds) {
    for (const std::size_t m : {1U, 10U, 1000U}) {
      const double ratio =
          allan_point(record_of(offset), kind, m).deviation / allan_point(record_of(rate), kind, m).deviation;
      EXPECT_NEAR(ratio, 1.0, 2.0 * std::ldexp(1.0, -23) / std::sqrt(12.0)) << m;
    }
  }
}

TEST(Allan, RampDoesNotReachTheHadamardDeviation) {
  // Integers below 2^53 all along: the ramp's third difference is exactly 0.
  std::vector<double> rate(5000);
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = static_cast<double>((i * 7919) % 101);
  std::vector<double> ramped = rate;
  for (std::size_t i = 0; i < rate.size(); ++i) ramped[i] += 3.0 * static_cast<double>(i);
  for (const AllanKind kind : {AllanKind::hadamard, AllanKind::overlapping_hadamard}) {
    for (const std::size_t m : {1U, 3U, 100U, 1500U}) {
      EXPECT_EQ(allan_point(record_of(ramped), kind, m).deviation, allan_point(record_of(rate), kind, m).deviation);
    }
  }
}

TEST(Allan, ScaleOfTheRateIsTheScaleOfTheDeviation) {
  // By a power of two: the same bits.
  const std::vector<double> rate = gaussian_noise(9000, 7);
  std::vector<double> scaled = rate;
  for (double& r : scaled) r *= -0.125;
  for (const AllanKind kind : kAllKinds) {
    for (const std::size_t m : {1U, 7U, 2500U}) {
      EXPECT_EQ(allan_point(record_of(scaled), kind, m).deviation,
                0.125 * allan_point(record_of(rate), kind, m).deviation);
    }
  }
}

TEST(Allan, RampHasItsDeviationExactly) {
  // R tau/sqrt(2) for all three Allan deviations: every second difference is R m^2, every mean of them too. Phase
  // i(i - 1)/2 are whole numbers below 2^53.
  std::vector<double> rate(200000);
  std::iota(rate.begin(), rate.end(), 0.0);
  const PhaseRecord record = record_of(rate);
  for (const AllanKind kind : {AllanKind::plain, AllanKind::overlapping, AllanKind::modified}) {
    for (const std::size_t m : {1U, 10U, 4096U, 60000U}) {
      const double expected = static_cast<double>(m) / std::sqrt(2.0);
      // Sums of equal squares: up to 50 blocks and 256 additions per lane, 2^-53 each.
      EXPECT_NEAR(allan_point(record, kind, m).deviation / expected, 1.0, 300 * 1.2e-16) << m;
    }
  }
}

TEST(Allan, WhitePhaseNoiseHasItsAnalyticDeviations) {
  // White phase of sigma 1 (quantisation: Q): Allan sqrt(3) sigma/m, modified Allan sqrt(3) sigma/m^1.5, Hadamard
  // sqrt(20/6) sigma/m. Relative standard error of each: below sqrt(2 * 1.94 / terms)/2, the squares of second
  // differences being correlated by (4/6)^2 and (1/6)^2 at two lags on either side (modified: windows of m share
  // points, m times fewer independent terms). Five of them.
  const std::size_t n = 400000;
  const auto record = PhaseRecord::from_phase(gaussian_noise(n, 8), 1.0);
  ASSERT_TRUE(record);
  for (const std::size_t m : {1U, 8U, 64U}) {
    const auto md = static_cast<double>(m);
    const double error = 5.0 * std::sqrt(2.0 * 1.94 / static_cast<double>(n)) / 2.0;
    EXPECT_NEAR(allan_point(*record, AllanKind::overlapping, m).deviation * md / std::sqrt(3.0), 1.0, error);
    EXPECT_NEAR(allan_point(*record, AllanKind::overlapping_hadamard, m).deviation * md / std::sqrt(20.0 / 6.0), 1.0,
                1.3 * error);
    EXPECT_NEAR(allan_point(*record, AllanKind::modified, m).deviation * std::pow(md, 1.5) / std::sqrt(3.0), 1.0,
                error * std::sqrt(md));
  }
}

TEST(Allan, WhiteRateNoiseHasItsAnalyticDeviations) {
  // White rate of sigma 1 per sample at 100 Hz: N = sigma/sqrt(rate), Allan N/sqrt(tau) = 1/sqrt(m), Hadamard the same;
  // modified sqrt((m^2 + 1)/(2 m^2)) of it. Relative standard error about sqrt(m/n); five of them.
  const std::size_t n = 400000;
  const auto record = PhaseRecord::from_rate(gaussian_noise(n, 9), 100.0);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->interval_s(), 0.01);
  for (const std::size_t m : {1U, 10U, 100U, 1000U}) {
    const auto md = static_cast<double>(m);
    const double error = 5.0 * std::sqrt(md / static_cast<double>(n));
    const double expected = 1.0 / std::sqrt(md);
    EXPECT_NEAR(allan_point(*record, AllanKind::overlapping, m).deviation / expected, 1.0, error);
    EXPECT_NEAR(allan_point(*record, AllanKind::plain, m).deviation / expected, 1.0, 2.0 * error);
    EXPECT_NEAR(allan_point(*record, AllanKind::overlapping_hadamard, m).deviation / expected, 1.0, 1.3 * error);
    const double modified = expected * std::sqrt((md * md + 1.0) / (2.0 * md * md));
    EXPECT_NEAR(allan_point(*record, AllanKind::modified, m).deviation / modified, 1.0, 1.3 * error);
  }
}

TEST(Allan, WithoutOverlapAtOneIntervalIsWithOverlap) {
  const PhaseRecord record = record_of(gaussian_noise(10000, 10));
  EXPECT_EQ(allan_point(record, AllanKind::plain, 1).deviation,
            allan_point(record, AllanKind::overlapping, 1).deviation);
  EXPECT_EQ(allan_point(record, AllanKind::hadamard, 1).deviation,
            allan_point(record, AllanKind::overlapping_hadamard, 1).deviation);
}

TEST(Allan, PhaseOfARateGivesTheSameDeviations) {
  const std::vector<double> rate = gaussian_noise(3000, 11);
  std::vector<double> angle = {5.0};
  for (const double r : rate) angle.push_back(angle.back() + r / 50.0);
  const auto from_angle = PhaseRecord::from_phase(angle, 50.0);
  ASSERT_TRUE(from_angle);
  const auto from_rate = PhaseRecord::from_rate(rate, 50.0);
  for (const AllanKind kind : kAllKinds) {
    // The angle's rounding (1e-16 times 3000 additions of random sign, at 50 per unit).
    EXPECT_NEAR(allan_point(*from_angle, kind, 20).deviation / allan_point(*from_rate, kind, 20).deviation, 1.0, 1e-11);
  }
}

TEST(Allan, ShortGapsAreBridgedAndLongOnesEndAStretch) {
  const double x = kMissing;
  const std::vector<double> rate = {x, x, 1, 2, x, x, 8, 9, x, x, x, 4, 5, 6, x};
  const PhaseRecord record = record_of(rate, 2);
  EXPECT_EQ(record.gaps().missing, 8U);
  EXPECT_EQ(record.gaps().bridged, 2U);
  EXPECT_EQ(record.gaps().gaps, 1U);
  ASSERT_EQ(record.stretches().size(), 2U);
  EXPECT_EQ(record.stretches()[0].first, 0U);
  EXPECT_EQ(record.stretches()[0].count, 7U);
  EXPECT_EQ(record.stretches()[1].first, 7U);
  EXPECT_EQ(record.stretches()[1].count, 4U);
  // Rates less the first: 0 1 3 5 7 8 | 3 4 5
  const std::vector<double> expected = {0, 0, 1, 4, 9, 16, 24, 0, 3, 7, 12};
  EXPECT_EQ(std::vector<double>(record.phase().begin(), record.phase().end()), expected);
  EXPECT_EQ(record.longest(AllanKind::overlapping), 3U);
  EXPECT_EQ(record.longest(AllanKind::modified), 2U);
  EXPECT_EQ(record.longest(AllanKind::overlapping_hadamard), 2U);
}

TEST(Allan, EveryGapInPhaseEndsAStretch) {
  const std::vector<double> phase = {1, 2, 4, kMissing, 10, 12, 14, kMissing, kMissing};
  const auto record = PhaseRecord::from_phase(phase, 2.0);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->gaps().missing, 3U);
  EXPECT_EQ(record->gaps().gaps, 2U);
  EXPECT_EQ(record->gaps().bridged, 0U);
  const std::vector<double> expected = {0, 2, 6, 0, 4, 8};
  EXPECT_EQ(std::vector<double>(record->phase().begin(), record->phase().end()), expected);
}

TEST(Allan, PhaseOfALongRecordIsRoundedOnlyOnce) {
  // 0.1 less 0 a million times: plain addition is off by 1e-6 after that; the exact sum of the double nearest to 0.1
  // rounds to 100000.
  std::vector<double> rate(1000001, 0.1);
  rate[0] = 0.0;
  EXPECT_EQ(record_of(rate).phase().back(), 100000.0);
}

TEST(Allan, RefusesWhatItCannotUse) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> good = {1, 2, 3};
  for (const double rate_hz : {0.0, -1.0, kMissing, infinity}) {
    EXPECT_FALSE(PhaseRecord::from_rate(good, rate_hz));
    EXPECT_FALSE(PhaseRecord::from_phase(good, rate_hz));
  }
  const auto infinite = PhaseRecord::from_rate(std::vector<double>{1, 2, -infinity, 3}, 1.0);
  ASSERT_FALSE(infinite);
  EXPECT_EQ(infinite.error().where, "sample 2");
  EXPECT_EQ(infinite.error().kind, base::ErrorKind::bad_input);
  EXPECT_FALSE(PhaseRecord::from_rate({}, 1.0));
  EXPECT_FALSE(PhaseRecord::from_rate(std::vector<double>{1, kMissing, 3}, 1.0, 0));
  EXPECT_TRUE(PhaseRecord::from_rate(std::vector<double>{1, kMissing, 3}, 1.0, 1));
  EXPECT_FALSE(PhaseRecord::from_phase(std::vector<double>{1, 2, kMissing, 4, 5}, 1.0));
}

TEST(Allan, LogSpacedMultiplesRiseEvenlyFromOneToTheLongest) {
  EXPECT_TRUE(log_spaced_multiples(0, 10).empty());
  EXPECT_EQ(log_spaced_multiples(1, 10), std::vector<std::size_t>{1});
  EXPECT_EQ(log_spaced_multiples(10, 100), all_multiples(10));
  EXPECT_EQ(log_spaced_multiples(1000, 1), (std::vector<std::size_t>{1, 10, 100, 1000}));
  const std::vector<std::size_t> multiples = log_spaced_multiples(4800000, 9);
  EXPECT_EQ(multiples.front(), 1U);
  EXPECT_EQ(multiples.back(), 4800000U);
  for (std::size_t k = 1; k < multiples.size(); ++k) {
    EXPECT_GT(multiples[k], multiples[k - 1]);
    // Steps of 10^(1/9) to 10^(1/8.9) within the rounding of both ends to whole numbers.
    const double step = static_cast<double>(multiples[k]) / static_cast<double>(multiples[k - 1]);
    if (multiples[k - 1] <= 10) continue;
    EXPECT_NEAR(step, 1.292, 1.0 / static_cast<double>(multiples[k - 1]) + 0.005);
  }
}

}  // namespace
}  // namespace soak::calib::signal
