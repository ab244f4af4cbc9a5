// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/sensor_model.h"

#include <gtest/gtest.h>

#include <cmath>


namespace soak::nav {
namespace {

using calib::signal::AllanFit;

TEST(SensorModel, TakesNoiseFromTheFitAndTheBiasFromItsGaussMarkovTerm) {
  AllanFit fit;
  fit.angle_random_walk = {0.002, 0.0019, 0.0021, true};
  fit.markov_sigma = {0.01, 0.009, 0.011, true};
  fit.markov_time_s = {120.0, 100.0, 140.0, true};
  const SensorModel model = sensor_model_of(fit, 0.3);
  EXPECT_EQ(model.white, 0.002);
  EXPECT_EQ(model.bias.sigma, 0.01);
  EXPECT_EQ(model.bias.time_s, 120.0);
  EXPECT_EQ(model.bias.start_sigma, 0.3);
}

TEST(SensorModel, TakesTheFlatPartWhereNoProcessWasFound) {
  AllanFit fit;
  fit.bias_instability = {0.01, 0.009, 0.011, true};
  fit.bias_instability_tau_s = 50.0;
  EXPECT_NEAR(sensor_model_of(fit, 0.0).bias.sigma, 0.00664, 1e-5);
  EXPECT_EQ(sensor_model_of(fit, 0.0).bias.time_s, 50.0);
}

TEST(SensorModel, LetsAShortRecordHideAWalk) {
  AllanFit fit;
  fit.bias_instability = {0.01, 0.0, 0.011, false};
  fit.bias_instability_tau_s = 4.0;
  const SensorModel model = sensor_model_of(fit, 0.0);
  EXPECT_EQ(model.bias.sigma, 0.0);
  EXPECT_TRUE(std::isinf(model.bias.time_s));
  EXPECT_NEAR(model.bias.walk, 0.00332, 1e-5);
}

}  // namespace
}  // namespace soak::nav
