// SPDX-License-Identifier: Apache-2.0
// Effects that power, time, compressor and supply drive, and those of the output word, each against its physics.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/sim/effect_support.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;
using test::at_rest;
using test::LoneEffect;

TEST(WarmupTransient, IsTwoExponentialsSincePowerOnAndBeginsAnewWithPower) {
  LoneEffect effect("warmup_transient");
  const double share = effect.shape("fast_share");
  for (const double t_s : {0.0, 100.0, 1000.0, 20000.0}) {
    const double expected =
        share * std::exp(-t_s / effect.shape("fast_s")) + (1.0 - share) * std::exp(-t_s / effect.shape("slow_s"));
    EXPECT_NEAR(effect.at(at_rest(t_s, 25.0)), expected, 1e-12);
  }
  Conditions off = at_rest(30000.0, 25.0);
  off.powered = false;
  EXPECT_EQ(effect.at(off), 0.0);
  Conditions again = at_rest(30030.0, 25.0);
  again.since_power_on_s = 0.0;
  EXPECT_EQ(effect.at(again), 1.0);
}

TEST(VibrationRectification, IsThereWhileTheCompressorRuns) {
  LoneEffect effect("vibration_rectification");
  Conditions now = at_rest(0.0, 25.0);
  EXPECT_EQ(effect.at(now), 0.0);
  now.time_s = 60.0;
  now.compressor = 1.0;
  EXPECT_NEAR(effect.at(now), 1.0, 2e-3);  // seven spin-up times
  now.time_s = 70.0;
  now.compressor = 0.0;
  EXPECT_LT(effect.at(now), 0.1);
}

TEST(SupplySensitivity, FollowsTheVoltageAbove5) {
  LoneEffect effect("supply_sensitivity");
  Conditions now = at_rest(0.0, 25.0);
  EXPECT_EQ(effect.at(now), 0.0);
  now.supply_v = 5.25;
  EXPECT_EQ(effect.at(now), 0.25);
}

TEST(AgingDrift, CountsThousandsOfHoursByTheCalendar) {
  LoneEffect effect("aging_drift");
  EXPECT_EQ(effect.at(at_rest(500.0, 25.0)), 0.0);
  EXPECT_NEAR(effect.at(at_rest(500.0 + 3.6e6, 70.0)), 1.0, 1e-9);
}

TEST(NoiseVsTemperature, MultipliesTheNoiseAndLeavesTheMean) {
  LoneEffect effect("noise_vs_temperature", 0.02);
  EXPECT_EQ(effect.at(at_rest(0.0, 75.0)), 0.0);
  EXPECT_NEAR(effect.effect->noise_factor(), std::exp(1.0), 1e-12);
  effect.at(at_rest(1.0, 25.0));
  EXPECT_EQ(effect.effect->noise_factor(), 1.0);
}

TEST(Quantization, GivesMultiplesOfItsStepWithinHalfAStep) {
  LoneEffect effect("quantization", 0.25);
  for (double value = -1.0; value < 1.0; value += 0.013) {
    const double word = effect.effect->output(Sensor::accel_y, value);
    EXPECT_EQ(std::fmod(word, 0.25), 0.0);
    EXPECT_LE(std::abs(word - value), 0.125 + 1e-12);
  }
}

TEST(Saturation, ClipsAtItsRailsOnly) {
  LoneEffect effect("saturation", 9.8);
  EXPECT_EQ(effect.effect->output(Sensor::accel_x, 9.9), 9.8);
  EXPECT_EQ(effect.effect->output(Sensor::accel_x, -12.0), -9.8);
  EXPECT_EQ(effect.effect->output(Sensor::accel_x, 9.7), 9.7);
}

TEST(DailyWave, ComesBackAfterADayAndPeaksAtItsHour) {
  LoneEffect effect("daily_wave");
  const double peak_s = (effect.shape("peak_hour") - 9.0) * 3600.0;  // the lab begins at 9:00
  EXPECT_NEAR(effect.at(at_rest(peak_s + 86400.0, 25.0)), 1.0, 1e-9);
  EXPECT_NEAR(effect.at(at_rest(peak_s + 2.5 * 86400.0, 25.0)), -1.0, 1e-9);
}

TEST(TelegraphNoise, HasTwoStatesThatLastAsLongAsItSays) {
  LoneEffect effect("telegraph_noise");
  std::set<double> states;
  int changes = 0;
  double last = effect.at(at_rest(0.0, 25.0));
  const double duration_s = 2000.0 * effect.shape("mean_stay_s");
  for (double t_s = 0.0; t_s < duration_s; t_s += 20.0) {
    const double state = effect.at(at_rest(t_s, 25.0));
    states.insert(state);
    changes += state != last ? 1 : 0;
    last = state;
  }
  EXPECT_EQ(states, (std::set<double>{-1.0, 1.0}));
  EXPECT_NEAR(changes, 2000, 240);  // Poisson: 4 · 45; up to 3 % of the changes are missed between the steps
}

TEST(BiasStep, StepsOnceInARunAndStaysUntilPowerGoes) {
  LoneEffect effect("bias_step");
  for (int run = 0; run < 20; ++run) {
    int changes = 0;
    double last = 0.0;
    for (int i = 0; i < 2000; ++i) {
      Conditions now = at_rest(100.0 * i, 25.0);
      now.run = run;
      const double value = effect.at(now);
      changes += value != last ? 1 : 0;
      last = value;
    }
    EXPECT_EQ(changes, 1) << run;
    EXPECT_GE(std::abs(last), 0.5);
    Conditions off = at_rest(2e5, 25.0);
    off.powered = false;
    EXPECT_EQ(effect.at(off), 0.0);
  }
}

}  // namespace
}  // namespace soak::hal::sim
