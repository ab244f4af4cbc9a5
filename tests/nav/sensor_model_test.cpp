// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/sensor_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace soak::nav {
namespace {

using calib::signal::AllanFit;

AllanFit with_process(double sigma, double time_s) {
  AllanFit fit;
  fit.angle_random_walk = {0.002, 0.0019, 0.0021, true};
  fit.markov_sigma = {sigma, 0.9 * sigma, 1.1 * sigma, true};
  fit.markov_time_s = {time_s, 0.9 * time_s, 1.1 * time_s, true};
  return fit;
}

TEST(SensorModel, TakesNoiseFromTheFitAndTheBiasFromItsGaussMarkovTerm) {
  const SensorModel model = sensor_model_of(with_process(0.01, 120.0), 0.3, StartOfBias::known);
  EXPECT_DOUBLE_EQ(model.white, 0.002);
  EXPECT_EQ(model.bias.sigma, 0.01);
  EXPECT_EQ(model.bias.time_s, 120.0);
  EXPECT_EQ(model.bias.start_sigma, 0.3);
}

TEST(SensorModel, AProcessAboutAnUnknownValueIsARandomWalk) {
  const SensorModel model = sensor_model_of(with_process(0.01, 200.0), 0.3, StartOfBias::unknown);
  EXPECT_EQ(model.bias.sigma, 0.0);
  // Variance grows by 2 σ²/T per second: 1e-6.
  EXPECT_NEAR(model.bias.walk, 1e-3, 1e-9);
}

TEST(SensorModel, AFastProcessIsWhiteNoise) {
  const SensorModel model = sensor_model_of(with_process(0.001, 1.0), 0.0, StartOfBias::known);
  EXPECT_EQ(model.bias.sigma, 0.0);
  EXPECT_NEAR(model.white, std::sqrt(4e-6 + 2e-6), 1e-9);
}

TEST(SensorModel, TakesTheFlatPartWhereNoProcessWasFound) {
  AllanFit fit;
  fit.bias_instability = {0.01, 0.009, 0.011, true};
  fit.bias_instability_tau_s = 50.0;
  const SensorModel model = sensor_model_of(fit, 0.0, StartOfBias::known);
  EXPECT_NEAR(model.bias.sigma, 0.00664, 1e-5);
  EXPECT_EQ(model.bias.time_s, 50.0);
}

TEST(SensorModel, LetsAShortRecordHideAWalk) {
  AllanFit fit;
  fit.bias_instability = {0.01, 0.0, 0.011, false};
  fit.bias_instability_tau_s = 4.0;
  const SensorModel model = sensor_model_of(fit, 0.0, StartOfBias::known);
  EXPECT_EQ(model.bias.sigma, 0.0);
  EXPECT_TRUE(std::isinf(model.bias.time_s));
  EXPECT_NEAR(model.bias.walk, 0.00332, 1e-5);
}

}  // namespace
}  // namespace soak::nav
