// SPDX-License-Identifier: Apache-2.0
// Effects that temperature drives, each against its physics.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/sim/effect_support.h"

namespace soak::hal::sim {
namespace {

using test::at_rest;
using test::LoneEffect;

/// Goes from one temperature to another in steps of 0.1 K; the responses on the way.
std::vector<double> ramp(LoneEffect& effect, double& time_s, double from_c, double to_c, double rate_kps) {
  std::vector<double> responses;
  const int steps = static_cast<int>(std::lround(std::abs(to_c - from_c) / 0.1));
  for (int i = 1; i <= steps; ++i) {
    time_s += 0.1 / rate_kps;
    responses.push_back(effect.at(at_rest(time_s, from_c + (to_c - from_c) * i / steps)));
  }
  return responses;
}

TEST(ThermalHysteresis, StaysAfterTheSoakAndHasTheSignOfTheWayThatWasGone) {
  LoneEffect effect("thermal_hysteresis");
  const double slope_pk = effect.shape("slope_pk");
  double time_s = 0.0;
  effect.at(at_rest(0.0, -20.0));
  const double up = ramp(effect, time_s, -20.0, 40.0, 0.03).back();
  EXPECT_NEAR(up, 1.0 + 15.0 * slope_pk, 1e-9);
  EXPECT_EQ(effect.at(at_rest(time_s + 1e5, 40.0)), up) << "a day later";
  ramp(effect, time_s, 40.0, 70.0, 0.03);
  EXPECT_NEAR(ramp(effect, time_s, 70.0, 10.0, 0.03).back(), -(1.0 - 15.0 * slope_pk), 1e-9);
}

TEST(ThermalHysteresis, ClosesItsLoopAndKnowsNoSpeed) {
  LoneEffect slow("thermal_hysteresis");
  LoneEffect fast("thermal_hysteresis");
  double slow_s = 0.0;
  double fast_s = 0.0;
  std::vector<double> loops[3];
  for (int loop = 0; loop < 3; ++loop) {
    loops[loop] = ramp(slow, slow_s, -20.0, 70.0, 0.01);
    const auto down = ramp(slow, slow_s, 70.0, -20.0, 0.01);
    loops[loop].insert(loops[loop].end(), down.begin(), down.end());
  }
  std::vector<double> quick = ramp(fast, fast_s, -20.0, 70.0, 1.0);
  const auto down = ramp(fast, fast_s, 70.0, -20.0, 1.0);
  quick.insert(quick.end(), down.begin(), down.end());
  EXPECT_EQ(quick, loops[0]);
  EXPECT_NE(loops[1], loops[0]) << "the first begins without a past";
  EXPECT_EQ(loops[2], loops[1]);
}

TEST(ThermalHysteresis, LeavesASmallerLoopWithinALargerOne) {
  LoneEffect effect("thermal_hysteresis");
  const double widest_c = effect.shape("widest_c");
  double time_s = 0.0;
  effect.at(at_rest(0.0, -20.0));
  const double before = ramp(effect, time_s, -20.0, 40.0, 0.03).back();
  const double turned = ramp(effect, time_s, 40.0, 40.0 - 0.5 * widest_c, 0.03).back();
  EXPECT_LT(turned, before - 0.3) << "narrow plays have turned round";
  EXPECT_GT(turned, -before + 0.3) << "wide ones have not";
  EXPECT_NEAR(ramp(effect, time_s, 40.0 - 0.5 * widest_c, 40.0, 0.03).back(), before, 0.05)
      << "the way back wipes the small turn out";
}

TEST(TemperatureRate, IsProportionalToTheRampAndDiesWithIt) {
  for (const double rate_kpmin : {0.5, 1.0, -2.0}) {
    LoneEffect effect("temperature_rate");
    const double slope_pk = effect.shape("slope_pk");
    effect.at(at_rest(0.0, 10.0));
    for (int i = 1; i <= 30; ++i) {
      const double temp_c = 10.0 + rate_kpmin / 60.0 * 10.0 * i;
      EXPECT_NEAR(effect.at(at_rest(10.0 * i, temp_c)), rate_kpmin * (1.0 + slope_pk * (temp_c - 25.0)), 1e-9);
    }
    EXPECT_EQ(effect.at(at_rest(310.0, 10.0 + rate_kpmin * 5.0)), 0.0);
  }
}

TEST(SensorLag, FollowsARampAsAFirstOrderNodeDoesHoweverTimeIsDivided) {
  const double tau_s = 120.0;
  const double slope_kps = 0.03;
  for (const double step_s : {0.1, 7.0, 30.0}) {
    LoneEffect effect("sensor_lag", tau_s);
    double time_s = 0.0;
    effect.effect->advance_to(at_rest(time_s, -20.0));
    while (time_s < 900.0) {
      time_s += step_s;
      effect.effect->advance_to(at_rest(time_s, -20.0 + slope_kps * time_s));
      const double behind_c = slope_kps * tau_s * (1.0 - std::exp(-time_s / tau_s));
      ASSERT_NEAR(effect.effect->element_shift_c(), -behind_c, 1e-9) << time_s;
    }
    const double settled_c = effect.effect->element_shift_c();
    effect.effect->advance_to(at_rest(time_s + 240.0, -20.0 + slope_kps * time_s));
    EXPECT_GT(effect.effect->element_shift_c(), settled_c) << "the soak lets it catch up";
  }
}

TEST(NarrowBump, IsHalfAsHighAtItsHalfWidthAndAStepIsHalfWayAtItsCentre) {
  int steps = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    LoneEffect effect("narrow_bump", 1.0, seed);
    const double centre_c = effect.shape("centre_c");
    const double width_c = effect.shape("half_width_c");
    EXPECT_GT(centre_c, -20.0);
    EXPECT_LT(centre_c, 70.0);
    if (effect.shape("is_step") > 0.5) {
      ++steps;
      EXPECT_NEAR(effect.at(at_rest(0.0, centre_c)), 0.5, 1e-12);
      EXPECT_NEAR(effect.at(at_rest(0.0, centre_c - 15.0)), 0.0, 1e-6);
      EXPECT_NEAR(effect.at(at_rest(0.0, centre_c + 15.0)), 1.0, 1e-6);
    } else {
      EXPECT_NEAR(effect.at(at_rest(0.0, centre_c)), 1.0, 1e-12);
      EXPECT_NEAR(effect.at(at_rest(0.0, centre_c + width_c)), 0.5, 1e-12);
      EXPECT_NEAR(effect.at(at_rest(0.0, centre_c - width_c)), 0.5, 1e-12);
    }
  }
  EXPECT_GT(steps, 8);  // of 40 tosses: 5 and 35 would be one in 10⁶
  EXPECT_LT(steps, 32);
}

TEST(GradientRate, IsTheRateOfTheDifferenceBetweenAirAndUnitOnceTheLidHasFollowed) {
  LoneEffect effect("gradient_rate");
  for (int i = 0; i <= 600; ++i) {
    Conditions now = at_rest(10.0 * i, 25.0);
    now.air_c = 25.0 + 10.0 * i / 60.0;  // 1 K/min
    effect.effect->advance_to(now);
  }
  EXPECT_NEAR(effect.effect->response(calib::Sensor::gyro_x), 1.0, 0.09);  // steps of 10 s against 60 s or more
}

TEST(Moisture, IsDrivenOutByHeatAndComesBackInTheCold) {
  LoneEffect effect("moisture");
  EXPECT_EQ(effect.at(at_rest(0.0, 20.0)), 1.0);
  const double dried = effect.at(at_rest(86400.0, 70.0));
  const double uptake = 1.0 / effect.shape("uptake_h");
  const double drying = std::exp2(20.0 / 12.0) / effect.shape("drying_h");
  const double settled = uptake / (uptake + drying);
  EXPECT_NEAR(dried, settled + (1.0 - settled) * std::exp(-24.0 * (uptake + drying)), 1e-9);
  EXPECT_GT(effect.at(at_rest(2 * 86400.0, -20.0)), 0.5);
}

}  // namespace
}  // namespace soak::hal::sim
