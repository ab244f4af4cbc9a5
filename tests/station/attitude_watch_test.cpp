// SPDX-License-Identifier: Apache-2.0
#include "station/lab/position_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace soak::station {
namespace {

constexpr double kGravity_mps2 = 9.80665;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

std::array<float, 3> force(double x, double y, double z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

/// Feeds samples at 100 Hz, from where the last ones ended.
class Bench {
 public:
  explicit Bench(const char* position, int sign_at_rest = 1) {
    watch.expect(*calib::position_named(position), sign_at_rest);
  }

  void stand(double seconds, const std::array<float, 3>& accel_mps2, double rate_dps = 0.0) {
    for (int i = 0; i < std::lround(100.0 * seconds); ++i) {
      hal::ImuSample sample;
      sample.t_s = t_s += 0.01;
      sample.accel_mps2 = accel_mps2;
      sample.rate_rps[1] = static_cast<float>(rate_dps * kRadPerDeg);
      watch.add(sample);
    }
  }

  AttitudeWatch watch;
  double t_s = 0.0;
};

/// +Z upwards, but for a tilt about x.
std::array<float, 3> tilted(double tilt_deg, double size_mps2 = kGravity_mps2) {
  return force(0.0, size_mps2 * std::sin(tilt_deg * kRadPerDeg), size_mps2 * std::cos(tilt_deg * kRadPerDeg));
}

TEST(AttitudeWatch, KnowsNothingBeforeItExpectsAPosition) {
  AttitudeWatch watch;
  hal::ImuSample sample;
  sample.accel_mps2 = tilted(0.0);
  for (int i = 0; i < 500; ++i) {
    sample.t_s = 0.01 * i;
    watch.add(sample);
  }
  EXPECT_EQ(watch.state(), Attitude::unknown);
}

TEST(AttitudeWatch, EveryPositionIsRightForItselfAndWrongForTheOthers) {
  for (const std::string_view expected : calib::kSixPositionLabels) {
    for (const std::string_view actual : calib::kSixPositionLabels) {
      const auto up = calib::position_named(actual)->up;
      Bench bench(std::string(expected).c_str());
      bench.stand(3.0, force(kGravity_mps2 * up[0], kGravity_mps2 * up[1], kGravity_mps2 * up[2]));
      EXPECT_EQ(bench.watch.state(), expected == actual ? Attitude::right : Attitude::wrong) << expected << actual;
      EXPECT_EQ(bench.watch.up_axis(), actual);
    }
  }
}

TEST(AttitudeWatch, AUnitThatReadsMinusGUpwardsIsJudgedByItsSign) {
  Bench bench("+Z", -1);
  bench.stand(3.0, force(0.0, 0.0, -kGravity_mps2));
  EXPECT_EQ(bench.watch.state(), Attitude::right);
  bench.stand(3.0, force(0.0, 0.0, kGravity_mps2));
  EXPECT_EQ(bench.watch.state(), Attitude::wrong);
}

TEST(AttitudeWatch, OfAUnitThatReadsMinusGUpwardsTheFaceThatIsUpIsNamed) {
  Bench bench("+Z", -1);
  bench.stand(3.0, force(0.0, 0.0, -kGravity_mps2));
  EXPECT_EQ(bench.watch.up_axis(), "+Z");
  bench.stand(3.0, force(kGravity_mps2, 0.0, 0.0));
  EXPECT_EQ(bench.watch.up_axis(), "-X");
}

TEST(AttitudeWatch, RestLastsTwoSeconds) {
  Bench bench("+Z");
  bench.stand(1.9, tilted(0.0));
  EXPECT_EQ(bench.watch.state(), Attitude::turning);
  bench.stand(0.2, tilted(0.0));
  EXPECT_EQ(bench.watch.state(), Attitude::right);
  bench.stand(0.01, tilted(0.0), 20.0);
  EXPECT_EQ(bench.watch.state(), Attitude::turning) << "a single sample interrupts";
  bench.stand(1.9, tilted(0.0));
  EXPECT_EQ(bench.watch.state(), Attitude::turning);
  bench.stand(0.2, tilted(0.0));
  EXPECT_EQ(bench.watch.state(), Attitude::right);
}

TEST(AttitudeWatch, BearsFiveDegreesAndATenthOfGravity) {
  const auto judged = [](const std::array<float, 3>& accel_mps2, double rate_dps = 0.0) {
    Bench bench("+Z");
    bench.stand(3.0, accel_mps2, rate_dps);
    return bench.watch.state();
  };
  EXPECT_EQ(judged(tilted(4.9)), Attitude::right);
  EXPECT_EQ(judged(tilted(-4.9)), Attitude::right);
  EXPECT_EQ(judged(tilted(5.1)), Attitude::wrong);
  EXPECT_EQ(judged(tilted(0.0, 1.09 * kGravity_mps2)), Attitude::right);
  EXPECT_EQ(judged(tilted(0.0, 1.11 * kGravity_mps2)), Attitude::wrong);
  EXPECT_EQ(judged(tilted(0.0, 0.89 * kGravity_mps2)), Attitude::wrong);
  EXPECT_EQ(judged(force(0.0, 0.0, 0.0)), Attitude::wrong);
  EXPECT_EQ(judged(tilted(0.0), 4.9), Attitude::right);
  EXPECT_EQ(judged(tilted(0.0), -5.1), Attitude::turning);
}

TEST(AttitudeWatch, AReadingThatIsNoNumberIsNeverRight) {
  Bench bench("+Z");
  bench.stand(3.0, force(0.0, 0.0, std::nan("")));
  EXPECT_NE(bench.watch.state(), Attitude::right);
}

TEST(AttitudeWatch, SamplesFromBeforeATurnDoNotCountForTheNewPosition) {
  Bench bench("+Z");
  bench.stand(10.0, tilted(0.0));
  bench.watch.expect(*calib::position_named("+Z"), 1);
  EXPECT_EQ(bench.watch.state(), Attitude::turning);
  bench.watch.expect(*calib::position_named("-Z"), 1);
  bench.stand(1.0, tilted(0.0));
  EXPECT_EQ(bench.watch.state(), Attitude::turning);
  bench.stand(1.5, tilted(180.0), 60.0);
  EXPECT_EQ(bench.watch.state(), Attitude::turning);
  bench.stand(2.1, tilted(180.0));
  EXPECT_EQ(bench.watch.state(), Attitude::right);
}

TEST(AttitudeWatch, ARestartBeginsTheStretchAnew) {
  // The time of the new life may pass where the old stretch began, or not reach it for long.
  for (const double old_stretch_began_s : {0.0, 50.0}) {
    Bench bench("+Z");
    bench.t_s = old_stretch_began_s;
    bench.stand(100.0, tilted(0.0));
    bench.t_s = 10.0;
    bench.stand(1.0, tilted(0.0));
    EXPECT_EQ(bench.watch.state(), Attitude::turning) << old_stretch_began_s;
    bench.stand(1.2, tilted(0.0));
    EXPECT_EQ(bench.watch.state(), Attitude::right) << old_stretch_began_s;
  }
}

TEST(AttitudeWatch, SeenIsTheAxisOfTheLatestSampleWithMostOfGravity) {
  Bench bench("+Z");
  bench.stand(0.1, force(-9.0, 3.0, 2.0));
  EXPECT_EQ(bench.watch.up_axis(), "-X");
  bench.stand(0.01, force(-1.0, 5.0, 4.9));
  EXPECT_EQ(bench.watch.up_axis(), "+Y");
}

}  // namespace
}  // namespace soak::station
