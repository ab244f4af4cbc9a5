// SPDX-License-Identifier: Apache-2.0
#include "station/lab/position_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace soak::station {
namespace {

/// Feeds samples at 100 Hz, from where the last ones ended.
class RateBench {
 public:
  RateBench(const char* position, double rate_dps) { watch.expect(*calib::position_named(position), rate_dps); }

  void turn(double seconds, const calib::Vector3& rate_dps, double swing_dps = 0.0) {
    for (int i = 0; i < std::lround(100.0 * seconds); ++i) {
      hal::ImuSample sample;
      sample.t_s = t_s += 0.01;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double noisy_dps = rate_dps[axis] + (i % 2 == 0 ? swing_dps : -swing_dps);
        sample.rate_rps[axis] = static_cast<float>(noisy_dps * std::numbers::pi / 180.0);
      }
      watch.add(sample);
    }
  }

  RateWatch watch;
  double t_s = 0.0;
};

TEST(RateWatch, BelievesNothingBeforeTwoSecondsOfTheRightRate) {
  RateBench bench("+Z", 60.0);
  EXPECT_FALSE(bench.watch.right());
  bench.turn(1.9, {0, 0, 60});
  EXPECT_FALSE(bench.watch.right());
  bench.turn(0.2, {0, 0, 60});
  EXPECT_TRUE(bench.watch.right());
  EXPECT_NEAR(*bench.watch.measured_dps(), 60.0, 1e-3);
}

TEST(RateWatch, CountsTheRateAboutWhatPointsUp) {
  RateBench below("-Y", 60.0);
  below.turn(2.1, {0, -60, 0});
  EXPECT_TRUE(below.watch.right()) << "the y gyro of a unit on its head reads the other sign";
  RateBench other("-Y", 60.0);
  other.turn(2.1, {0, 60, 0});
  EXPECT_FALSE(other.watch.right());
  EXPECT_NEAR(*other.watch.measured_dps(), -60.0, 1e-3);
}

TEST(RateWatch, ForgivesTheUnitItsOwnErrorsAndTheFixtureNone) {
  RateBench unit("+X", 100.0);
  unit.turn(2.1, {103.5, 3, -3}, 5.0);
  EXPECT_TRUE(unit.watch.right()) << "bias, scale, misalignment, noise";
  RateBench slow("+X", 100.0);
  slow.turn(2.1, {90, 0, 0});
  EXPECT_FALSE(slow.watch.right());
  RateBench tilted("+X", 100.0);
  tilted.turn(2.1, {98, 15, 0});
  EXPECT_FALSE(tilted.watch.right()) << "it turns about something else as well";
}

TEST(RateWatch, JudgesTheLastTwoSecondsAndBeginsAnewWithEachRate) {
  RateBench bench("+Z", 60.0);
  bench.turn(2.1, {0, 0, 30});
  EXPECT_FALSE(bench.watch.right()) << "still speeding up";
  bench.turn(4.0, {0, 0, 60});
  EXPECT_TRUE(bench.watch.right());
  bench.turn(4.0, {0, 0, 30});
  EXPECT_FALSE(bench.watch.right()) << "it has slowed down";
  bench.turn(4.0, {0, 0, 60});
  bench.watch.expect(*calib::position_named("+Z"), 60.0);
  EXPECT_FALSE(bench.watch.right());
  EXPECT_EQ(bench.watch.measured_dps(), std::nullopt);
}

TEST(RateWatch, ARestartOfTheUnitsClockBeginsTheTwoSecondsAnew) {
  RateBench bench("+Z", 60.0);
  bench.turn(1.9, {0, 0, 60});
  bench.t_s = 0.0;
  bench.turn(1.0, {0, 0, 60});
  EXPECT_FALSE(bench.watch.right());
  bench.turn(1.2, {0, 0, 60});
  EXPECT_TRUE(bench.watch.right());
}

}  // namespace
}  // namespace soak::station
