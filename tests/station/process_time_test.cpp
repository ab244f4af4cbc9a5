// SPDX-License-Identifier: Apache-2.0
#include "station/lab/unit_channel.h"

#include <gtest/gtest.h>

#include <vector>

namespace soak::station {
namespace {

using std::chrono::milliseconds;

/// Units whose samples reach the lab, and the lab's time that follows from them.
class Lab {
 public:
  Lab(std::size_t units, double clock_rate) : time_(clock_rate), units_(units), streaming_(units, false) {
    time_.advance(host_, std::nullopt);
  }

  struct Arrival {
    std::size_t unit = 0;
    double advance_s = 0.0;
    bool began_anew = false;
  };

  /// One turn of the engine, `host` after the last one. A streaming unit that brings nothing stands where it stood.
  void turn(milliseconds host, const std::vector<Arrival>& arrivals) {
    host_ += host;
    std::vector<Arrival> all(units_.size());
    for (const Arrival& arrival : arrivals) {
      all[arrival.unit] = arrival;
      streaming_[arrival.unit] = true;
    }
    std::optional<double> furthest_s;
    for (std::size_t u = 0; u < units_.size(); ++u) {
      if (!streaming_[u]) continue;
      const double at_s = units_[u].follow(time_.now_s(), all[u].began_anew, all[u].advance_s);
      furthest_s = std::max(furthest_s.value_or(at_s), at_s);
    }
    time_.advance(host_, furthest_s);
  }

  void stop(std::size_t unit) {
    streaming_[unit] = false;
    units_[unit].lose();
  }

  [[nodiscard]] double now_s() const { return time_.now_s(); }

 private:
  ProcessTime time_;
  std::vector<UnitClock> units_;
  std::vector<bool> streaming_;
  std::chrono::steady_clock::time_point host_{std::chrono::hours{1000}};
};

TEST(ProcessTime, WithoutUnitsFollowsTheHostTimesTheRate) {
  for (const double rate : {1.0, 20.0}) {
    Lab lab(0, rate);
    EXPECT_EQ(lab.now_s(), 0.0);
    for (int i = 0; i < 100; ++i) lab.turn(milliseconds{50}, {});
    EXPECT_NEAR(lab.now_s(), 5.0 * rate, 1e-9);
  }
}

TEST(ProcessTime, TenUnitsWhoseBatchesComeOneByOneMoveItAtTheirPace) {
  Lab lab(10, 1.0);
  for (std::size_t u = 0; u < 10; ++u) lab.turn(milliseconds{1}, {{u, 0.0, true}});
  const double start_s = lab.now_s();
  // Each turn brings a second of one unit only: ten turns are one second of the laboratory.
  for (int second = 0; second < 100; ++second) {
    for (std::size_t u = 0; u < 10; ++u) lab.turn(milliseconds{1}, {{u, 1.0}});
  }
  EXPECT_NEAR(lab.now_s() - start_s, 100.0, 1e-9);
}

TEST(ProcessTime, UnitsTogetherOrAloneGiveTheSameTime) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{3}}) {
    Lab lab(count, 7.0);
    std::vector<Lab::Arrival> together;
    for (std::size_t u = 0; u < count; ++u) together.push_back({u, 0.02});
    for (int i = 0; i < 500; ++i) lab.turn(milliseconds{3}, together);
    EXPECT_NEAR(lab.now_s(), 10.0, 1e-9) << "the host's clock does not count while units stream";
  }
}

TEST(ProcessTime, AUnitThatBeginsAnewGoesOnFromNow) {
  Lab lab(2, 1.0);
  for (int i = 0; i < 50; ++i) lab.turn(milliseconds{1}, {{0, 1.0}, {1, 1.0}});
  // Unit 1 restarts, and has sent 3 s of its new life within one turn.
  lab.turn(milliseconds{1}, {{0, 1.0}, {1, 3.0, true}});
  EXPECT_NEAR(lab.now_s(), 53.0, 1e-9);
  for (int i = 0; i < 10; ++i) lab.turn(milliseconds{1}, {{0, 1.0}, {1, 1.0}});
  EXPECT_NEAR(lab.now_s(), 63.0, 1e-9);
}

TEST(ProcessTime, AUnitThatLaggedIsPutAtNowWhenItBeginsAnew) {
  Lab lab(2, 1.0);
  lab.turn(milliseconds{1}, {{0, 100.0}, {1, 60.0}});
  lab.turn(milliseconds{1}, {{1, 3.0, true}});
  EXPECT_NEAR(lab.now_s(), 103.0, 1e-9);
}

TEST(ProcessTime, AUnitThatComesBackDoesNotBringBackTheTimeThatItWasAway) {
  Lab lab(2, 1.0);
  for (int i = 0; i < 10; ++i) lab.turn(milliseconds{1}, {{0, 1.0}, {1, 1.0}});
  lab.stop(1);
  for (int i = 0; i < 100; ++i) lab.turn(milliseconds{1}, {{0, 1.0}});
  EXPECT_NEAR(lab.now_s(), 110.0, 1e-9) << "the other one goes on";
  lab.turn(milliseconds{1}, {{1, 0.5}});
  EXPECT_NEAR(lab.now_s(), 110.5, 1e-9);
}

TEST(ProcessTime, FallsBackToTheHostWhenTheLastUnitStops) {
  Lab lab(1, 10.0);
  for (int i = 0; i < 10; ++i) lab.turn(milliseconds{1}, {{0, 2.0}});
  EXPECT_NEAR(lab.now_s(), 20.0, 1e-9);
  lab.stop(0);
  for (int i = 0; i < 10; ++i) lab.turn(milliseconds{100}, {});
  EXPECT_NEAR(lab.now_s(), 30.0, 1e-9);
  lab.turn(milliseconds{100}, {{0, 0.25, true}});
  EXPECT_NEAR(lab.now_s(), 30.25, 1e-9);
}

TEST(ProcessTime, AUnitThatSendsNothingHoldsItWhereItIs) {
  Lab lab(1, 1.0);
  lab.turn(milliseconds{1}, {{0, 4.0}});
  for (int i = 0; i < 10; ++i) lab.turn(milliseconds{500}, {});
  EXPECT_NEAR(lab.now_s(), 4.0, 1e-9);
}

TEST(ProcessTime, NeverGoesBack) {
  Lab lab(3, 1.0);
  double before_s = 0.0;
  const auto expect_no_return = [&](const char* what) {
    EXPECT_GE(lab.now_s(), before_s) << what;
    before_s = lab.now_s();
  };
  lab.turn(milliseconds{1}, {{0, 100.0}, {1, 60.0}, {2, 59.0}});
  expect_no_return("units apart");
  lab.stop(0);
  lab.turn(milliseconds{1}, {{1, 1.0}});
  expect_no_return("the one ahead is gone");
  EXPECT_EQ(before_s, 100.0);
  lab.turn(milliseconds{1}, {{1, 0.0, true}});
  expect_no_return("a restart");
  lab.turn(milliseconds{1}, {{0, 0.0}});
  expect_no_return("back again");
  lab.turn(milliseconds{1}, {{0, 2.0}, {1, 1.0}, {2, 1.0}});
  EXPECT_NEAR(lab.now_s(), 102.0, 1e-9);
}

}  // namespace
}  // namespace soak::station
