// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/chamber_plant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hal/sim/lab/device_time.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

/// The shipped chamber under control.
class ControlledChamber {
 public:
  ControlledChamber() { controller_.switch_control(true); }

  /// Goes to a set point and stays; the overshoot, K.
  double go_to(double set_point_c, double duration_s) {
    const double direction = set_point_c > plant_.air_c() ? 1.0 : -1.0;
    double overshoot_k = 0.0;
    controller_.set_set_point_c(set_point_c);
    for (double t_s = 0.0; t_s < duration_s; t_s += kStep_s) {
      controller_.step(kStep_s, plant_.air_c());
      plant_.step(kStep_s, controller_.output());
      overshoot_k = std::max(overshoot_k, direction * (plant_.air_c() - set_point_c));
    }
    return overshoot_k;
  }

  [[nodiscard]] double air_c() const { return plant_.air_c(); }

 private:
  LabMagnitudes magnitudes_ = test::shipped_config().lab;
  ChamberPlant plant_{magnitudes_.plant};
  TemperatureController controller_{magnitudes_.controller, magnitudes_.plant.room_c};
};

TEST(TemperatureController, OvershootsStepsOfFiveKelvinByHalfToOneAndAHalf) {
  ControlledChamber chamber;
  chamber.go_to(-30.0, 7200.0);
  for (double set_point_c = -25.0; set_point_c <= 70.0; set_point_c += 5.0) {
    const double overshoot_k = chamber.go_to(set_point_c, 1800.0);
    EXPECT_GT(overshoot_k, 0.5) << set_point_c;
    EXPECT_LT(overshoot_k, 1.5) << set_point_c;
    EXPECT_NEAR(chamber.air_c(), set_point_c, 0.15);
  }
  for (double set_point_c = 65.0; set_point_c >= -30.0; set_point_c -= 5.0) {
    const double overshoot_k = chamber.go_to(set_point_c, 1800.0);
    EXPECT_GT(overshoot_k, 0.5) << set_point_c;
    EXPECT_LT(overshoot_k, 1.5) << set_point_c;
    EXPECT_NEAR(chamber.air_c(), set_point_c, 0.15);
  }
}

// The integral is not wound up on the way: the overshoot of a large step is that of a small one.
TEST(TemperatureController, OvershootsLargeStepsNoMore) {
  ControlledChamber chamber;
  EXPECT_LT(chamber.go_to(-40.0, 9000.0), 1.5);
  EXPECT_LT(chamber.go_to(85.0, 9000.0), 1.5);
  EXPECT_LT(chamber.go_to(25.0, 9000.0), 1.5);
}

class TemperatureControllerAlone : public testing::Test {
 protected:
  TemperatureController controller_{test::shipped_config().lab.controller, 20.0};

  void hold_air_at(double air_c, double duration_s) {
    for (double t_s = 0.0; t_s < duration_s - kStep_s / 2.0; t_s += kStep_s) controller_.step(kStep_s, air_c);
  }
};

TEST_F(TemperatureControllerAlone, GivesNoOutputFromTheMomentThatControlIsOff) {
  controller_.switch_control(true);
  controller_.set_set_point_c(60.0);
  hold_air_at(20.0, 10.0);
  EXPECT_EQ(controller_.output(), 1.0);
  controller_.switch_control(false);
  EXPECT_EQ(controller_.output(), 0.0);
  hold_air_at(20.0, 10.0);
  EXPECT_EQ(controller_.output(), 0.0);
}

TEST_F(TemperatureControllerAlone, RampsTheWorkingSetPointAtTheRateAsked) {
  controller_.set_ramp({.at_start = false, .at_set_point = true, .rate_kps = 0.05});
  controller_.switch_control(true);
  controller_.set_set_point_c(50.0);
  hold_air_at(20.0, 100.0);
  EXPECT_NEAR(controller_.working_set_point_c(), 25.0, 1e-6);
  hold_air_at(20.0, 600.0);
  EXPECT_EQ(controller_.working_set_point_c(), 50.0);
}

TEST_F(TemperatureControllerAlone, RampsFromTheProcessValueAtTheStartOnly) {
  controller_.set_ramp({.at_start = true, .at_set_point = false, .rate_kps = 0.05});
  controller_.set_set_point_c(30.0);
  controller_.switch_control(true);
  hold_air_at(20.0, 100.0);
  EXPECT_NEAR(controller_.working_set_point_c(), 25.0, 1e-6);
  hold_air_at(20.0, 101.0);
  ASSERT_EQ(controller_.working_set_point_c(), 30.0);
  controller_.set_set_point_c(-10.0);
  hold_air_at(20.0, kStep_s);
  EXPECT_EQ(controller_.working_set_point_c(), -10.0);
}

// First-order lag of the sensor: after one time constant 1 − 1/e of the way.
TEST_F(TemperatureControllerAlone, FeelsTheAirWithTheLagOfItsSensor) {
  hold_air_at(30.0, test::shipped_config().lab.controller.sensor_lag_s);
  EXPECT_NEAR(controller_.sensed_c(), 30.0 - 10.0 * std::exp(-1.0), 0.05);
}

TEST(LatchedTrip, StaysTrippedUntilControlIsOffAndTheTemperatureIsBack) {
  LatchedTrip trip(90.0);
  trip.check(90.0, true);
  EXPECT_FALSE(trip.tripped());
  trip.check(90.1, true);
  EXPECT_TRUE(trip.tripped());
  trip.check(20.0, true);
  EXPECT_TRUE(trip.tripped()) << "control is on";
  trip.check(90.1, false);
  EXPECT_TRUE(trip.tripped()) << "still too hot";
  trip.check(20.0, false);
  EXPECT_FALSE(trip.tripped());
}

}  // namespace
}  // namespace soak::hal::sim
