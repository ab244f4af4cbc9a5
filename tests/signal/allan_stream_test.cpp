// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/allan_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "allan_reference.h"

namespace soak::calib::signal {
namespace {

using test::gaussian_noise;
using test::kMissing;
using test::make_gaps;

AllanStream stream_of(const std::vector<double>& rate, std::size_t chunk, std::size_t bridge = PhaseRecord::kBridge) {
  AllanStream stream = *AllanStream::create(200.0, bridge);
  for (std::size_t i = 0; i < rate.size(); i += chunk) {
    EXPECT_TRUE(stream.push(std::span(rate).subspan(i, std::min(chunk, rate.size() - i))));
  }
  return stream;
}

void expect_same_points(const std::vector<AllanStream::Point>& a, const std::vector<AllanStream::Point>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].multiple, b[k].multiple);
    EXPECT_EQ(a[k].terms, b[k].terms);
    EXPECT_TRUE(test::same_value(a[k].overlapping, b[k].overlapping)) << a[k].multiple;
    EXPECT_TRUE(test::same_value(a[k].modified, b[k].modified)) << a[k].multiple;
    EXPECT_TRUE(test::same_value(a[k].overlapping_hadamard, b[k].overlapping_hadamard)) << a[k].multiple;
  }
}

void expect_bits_of_batch(const std::vector<AllanStream::Point>& points, const PhaseRecord& record) {
  for (const AllanStream::Point& point : points) {
    if (point.multiple > AllanStream::kExact) break;
    const auto batch = [&](AllanKind kind) { return allan_point(record, kind, point.multiple); };
    EXPECT_EQ(point.terms, batch(AllanKind::overlapping).terms);
    EXPECT_TRUE(test::same_value(point.overlapping, batch(AllanKind::overlapping).deviation)) << point.multiple;
    EXPECT_TRUE(test::same_value(point.modified, batch(AllanKind::modified).deviation)) << point.multiple;
    EXPECT_TRUE(test::same_value(point.overlapping_hadamard, batch(AllanKind::overlapping_hadamard).deviation))
        << point.multiple;
  }
}

/// Three stretches of about 20000 samples and some short ones, gaps of up to 12.
std::vector<double> noise_with_gaps(std::size_t count, std::uint64_t seed) {
  std::vector<double> rate = gaussian_noise(count, seed);
  make_gaps(rate, 10000, 12, seed);
  for (const std::size_t at : {std::size_t{0}, count / 2, count / 2 + 9, count / 2 + 30}) {
    for (std::size_t k = 0; k < 7; ++k) rate[at + k] = kMissing;
  }
  return rate;
}

TEST(AllanStream, GivesTheBitsOfTheBatchUpToTheExactMultiple) {
  for (const std::size_t count : {2U, 3U, 4U, 100U, 4096U, 8191U, 12289U, 16383U, 16384U, 60000U}) {
    const std::vector<double> rate = gaussian_noise(count, count);
    const std::vector<AllanStream::Point> points = stream_of(rate, count).points();
    ASSERT_FALSE(points.empty());
    expect_bits_of_batch(points, *PhaseRecord::from_rate(rate, 200.0));
  }
}

TEST(AllanStream, GivesTheBitsOfTheBatchOnRecordsWithGaps) {
  const std::vector<double> rate = noise_with_gaps(80000, 1);
  for (const std::size_t bridge : {0U, 5U, 11U}) {
    const AllanStream stream = stream_of(rate, 1000, bridge);
    const PhaseRecord record = *PhaseRecord::from_rate(rate, 200.0, bridge);
    expect_bits_of_batch(stream.points(), record);
    EXPECT_EQ(stream.interval_s(), record.interval_s());
    EXPECT_EQ(stream.gaps().missing, record.gaps().missing);
    EXPECT_EQ(stream.gaps().bridged, record.gaps().bridged);
    EXPECT_EQ(stream.gaps().gaps, record.gaps().gaps);
    ASSERT_EQ(stream.stretches().size(), record.stretches().size());
    ASSERT_GE(stream.stretches().size(), 3U);
    for (std::size_t k = 0; k < stream.stretches().size(); ++k) {
      EXPECT_EQ(stream.stretches()[k], record.stretches()[k].count);
    }
  }
}

TEST(AllanStream, SizesOfThePiecesChangeNoBit) {
  const std::vector<double> rate = noise_with_gaps(70000, 2);
  const std::vector<AllanStream::Point> whole = stream_of(rate, rate.size()).points();
  // Beyond the exact multiple too.
  EXPECT_GT(whole.back().multiple, AllanStream::kExact);
  for (const std::size_t chunk : {1U, 3U, 4095U, 4096U, 4097U, 33333U}) {
    expect_same_points(stream_of(rate, chunk).points(), whole);
  }
}

TEST(AllanStream, AskingInBetweenChangesNothing) {
  const std::vector<double> rate = noise_with_gaps(60000, 3);
  AllanStream stream = *AllanStream::create(200.0);
  for (std::size_t i = 0; i < rate.size(); i += 7001) {
    ASSERT_TRUE(stream.push(std::span(rate).subspan(i, std::min<std::size_t>(7001, rate.size() - i))));
    const std::vector<double> so_far(rate.begin(),
                                     rate.begin() + static_cast<std::ptrdiff_t>(std::min(i + 7001, rate.size())));
    expect_same_points(stream.points(), stream_of(so_far, so_far.size()).points());
  }
}

TEST(AllanStream, AveragingTimesAreWholeMultiplesThenFourToAnOctave) {
  const std::vector<AllanStream::Point> points = stream_of(gaussian_noise(50000, 4), 50000).points();
  std::set<std::size_t> expected = {1, 2, 3};
  for (std::size_t power = 1; 4 * power <= 25000; power *= 2) {
    for (std::size_t m = 4 * power; m < 8 * power && m <= 25000; m += power) expected.insert(m);
  }
  ASSERT_EQ(points.size(), expected.size());
  EXPECT_TRUE(std::equal(points.begin(), points.end(), expected.begin(),
                         [](const AllanStream::Point& point, std::size_t m) { return point.multiple == m; }));
}

TEST(AllanStream, HasAPointAsSoonAsThereIsADifference) {
  for (const std::size_t count : {0U, 1U}) EXPECT_TRUE(stream_of(gaussian_noise(count, 5), 1).points().empty());
  const std::vector<AllanStream::Point> points = stream_of({1.0, 3.0}, 1).points();
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].terms, 1U);
  EXPECT_DOUBLE_EQ(points[0].overlapping, std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(points[0].modified, std::sqrt(2.0));
  EXPECT_TRUE(std::isnan(points[0].overlapping_hadamard));
  // The longest: 2m samples, m = 2^16 beyond the exact multiple.
  const std::vector<double> rate = gaussian_noise(131072, 6);
  EXPECT_EQ(stream_of(rate, rate.size()).points().back().multiple, 65536U);
}

/// The differences that a thinned level is to count, by their definition: every `spacing`-th of all.
double thinned_by_definition(const PhaseRecord& record, AllanKind kind, std::size_t m, std::size_t spacing) {
  const std::span<const double> x = record.phase();
  std::vector<long double> cumulative = {0.0L};
  for (const double point : x) cumulative.push_back(cumulative.back() + point);
  const auto term = [&](std::size_t i) -> long double {
    if (kind == AllanKind::overlapping) return x[i + 2 * m] - 2.0L * x[i + m] + x[i];
    if (kind == AllanKind::overlapping_hadamard) return x[i + 3 * m] - 3.0L * x[i + 2 * m] + 3.0L * x[i + m] - x[i];
    return (cumulative[i + 3 * m] - 3.0L * cumulative[i + 2 * m] + 3.0L * cumulative[i + m] - cumulative[i]) /
           static_cast<long double>(m);
  };
  // The last window of modified Allan ends with the last point, the last difference of the others on it.
  const std::size_t reach = kind == AllanKind::overlapping ? 2 * m + 1
                            : kind == AllanKind::modified  ? 3 * m
                                                           : 3 * m + 1;
  long double sum = 0.0L;
  std::size_t terms = 0;
  for (std::size_t i = 0; i + reach <= x.size(); i += spacing, ++terms) sum += term(i) * term(i);
  const long double mean = sum / static_cast<long double>(terms);
  return static_cast<double>(std::sqrt(mean / (kind == AllanKind::overlapping_hadamard ? 6.0L : 2.0L))) /
         static_cast<double>(m);
}

TEST(AllanStream, BeyondTheExactMultipleDifferencesStartAtEverySecondFourthEighthSample) {
  const std::vector<double> rate = gaussian_noise(100001, 7);
  const PhaseRecord record = *PhaseRecord::from_rate(rate, 200.0);
  std::size_t checked = 0;
  for (const AllanStream::Point& point : stream_of(rate, 10000).points()) {
    std::size_t spacing = 1;
    while (point.multiple > spacing * AllanStream::kExact) spacing *= 2;
    if (spacing == 1) continue;
    ++checked;
    const auto expected = [&](AllanKind kind) { return thinned_by_definition(record, kind, point.multiple, spacing); };
    // Phase below 1e3 with differences of 100: 1e-13 from rounding, more where few terms are small by chance.
    EXPECT_NEAR(point.overlapping / expected(AllanKind::overlapping), 1.0, 1e-11) << point.multiple;
    if (3 * point.multiple >= rate.size()) continue;
    EXPECT_NEAR(point.overlapping_hadamard / expected(AllanKind::overlapping_hadamard), 1.0, 1e-11) << point.multiple;
    EXPECT_NEAR(point.modified / expected(AllanKind::modified), 1.0, 1e-11) << point.multiple;
  }
  EXPECT_EQ(checked, 14U);
}

TEST(AllanStream, BeyondTheExactMultipleItIsTheBatchWithinTheStatedBound) {
  // White rate noise. The squared second difference, as a process over its beginning t, has the covariance
  // 2(1 - 1.5|t|/m)^2 (Hadamard: 5/3 for 1.5) of its mean: near 0 a random walk that gains c d over a distance d,
  // c = 12/m (40/3m). Between beginnings d apart, the mean of the neighbours misses that of the walk by a bridge of
  // variance c d/12 in each of T/d cells, T = n - 2m: relative variance d^2/(mT). The ends, where the sums of the two
  // do not begin and end alike, add at most 3 d^2/T^2 with the variance 2 of the squares. Half of the root for the
  // deviation: d/(2T) sqrt(3 + T/m), as stated. Five of these; modified Allan is smoother.
  const std::size_t n = 300000;
  const std::vector<double> rate = gaussian_noise(n, 8);
  const PhaseRecord record = *PhaseRecord::from_rate(rate, 200.0);
  const auto bound = [&](std::size_t m, std::size_t spacing, std::size_t reach) {
    const double t = static_cast<double>(n - reach * m);
    return 5.0 * static_cast<double>(spacing) / (2.0 * t) * std::sqrt(3.0 + t / static_cast<double>(m));
  };
  for (const AllanStream::Point& point : stream_of(rate, n).points()) {
    const std::size_t m = point.multiple;
    if (m <= AllanStream::kExact || 4 * m > n) continue;
    std::size_t spacing = 1;
    while (m > spacing * AllanStream::kExact) spacing *= 2;
    const auto batch = [&](AllanKind kind) { return allan_point(record, kind, m).deviation; };
    EXPECT_NEAR(point.overlapping / batch(AllanKind::overlapping), 1.0, bound(m, spacing, 2)) << m;
    EXPECT_NEAR(point.overlapping_hadamard / batch(AllanKind::overlapping_hadamard), 1.0, bound(m, spacing, 3)) << m;
    EXPECT_NEAR(point.modified / batch(AllanKind::modified), 1.0, bound(m, spacing, 3)) << m;
  }
}

TEST(AllanStream, RampHasItsDeviationExactlyAtEveryAveragingTime) {
  std::vector<double> rate(100000);
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = static_cast<double>(i);
  for (const AllanStream::Point& point : stream_of(rate, 1 << 14).points()) {
    const double expected = static_cast<double>(point.multiple) / std::sqrt(2.0);
    // Sums of equal squares; means of pairs of whole numbers are exact.
    EXPECT_NEAR(point.overlapping / expected, 1.0, 300 * 1.2e-16) << point.multiple;
    if (3 * point.multiple >= rate.size()) continue;
    EXPECT_NEAR(point.modified / expected, 1.0, 300 * 1.2e-16) << point.multiple;
    EXPECT_EQ(point.overlapping_hadamard, 0.0) << point.multiple;
  }
}

TEST(AllanStream, RefusesAnInfiniteSampleAndTakesNothingOfItsPiece) {
  EXPECT_FALSE(AllanStream::create(0.0));
  EXPECT_FALSE(AllanStream::create(kMissing));
  const std::vector<double> rate = gaussian_noise(100, 9);
  AllanStream stream = stream_of(rate, 100);
  const auto status = stream.push(std::vector<double>{1.0, kMissing, std::numeric_limits<double>::infinity()});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "sample 102");
  EXPECT_EQ(stream.gaps().missing, 0U);
  expect_same_points(stream.points(), stream_of(rate, 100).points());
}

}  // namespace
}  // namespace soak::calib::signal
