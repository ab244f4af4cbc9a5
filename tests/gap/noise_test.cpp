// SPDX-License-Identifier: Apache-2.0
// Nested noise: its estimation from replicates and the whitening with it.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/noise/noise.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

TEST(NoiseComponents, AreThoseOfTheCampaign) {
  made_up::Plan plan;
  plan.runs = 20;
  const auto campaign = made_up::campaign(plan, made_up::nothing());
  const Observations observations = observe(campaign);
  const TemperatureHistory history(campaign, observations);
  const CampaignModel model(observations, history);
  for (const Sensor sensor : kSensors) {
    const double block = is_gyro(sensor) ? plan.gyro_block : plan.accel_block;
    const NoiseComponents& noise = model.residuals().noise[index_of(sensor)];
    EXPECT_TRUE(noise.replicated);
    EXPECT_NEAR(noise.block / block, 1.0, 0.05) << name_of(sensor);
    EXPECT_NEAR(noise.placement / block, 0.5, 0.1) << name_of(sensor);
    EXPECT_NEAR(noise.visit / block, 0.5, 0.12) << name_of(sensor);
  }
}

// What every run repeats is no noise, however large.
TEST(NoiseComponents, LeaveOutWhatTheRunsShare) {
  made_up::Plan plan;
  const auto shared = [&](Sensor sensor, const made_up::Moment& moment) {
    return (is_gyro(sensor) ? plan.gyro_block : plan.accel_block) * 5.0 * std::sin(1.7 * moment.visit);
  };
  const auto campaign = made_up::campaign(plan, shared);
  const Observations observations = observe(campaign);
  const TemperatureHistory history(campaign, observations);
  const CampaignModel model(observations, history);
  EXPECT_NEAR(model.residuals().noise[0].visit / plan.gyro_block, 0.5, 0.25);
}

TEST(Whitening, MakesNestedNoiseWhite) {
  made_up::Plan plan;
  plan.runs = 2;
  plan.levels = 2;
  const Observations observations = observe(made_up::campaign(plan, made_up::nothing()));
  NoiseComponents noise;
  noise.block = 1.0;
  noise.placement = 0.7;
  noise.visit = 1.3;
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const Observation& first = observations.rows[static_cast<std::size_t>(a)];
      const Observation& second = observations.rows[static_cast<std::size_t>(b)];
      if (first.run == second.run && first.visit == second.visit) covariance(a, b) += 1.3 * 1.3;
      if (first.placement == second.placement) covariance(a, b) += 0.7 * 0.7;
      if (a == b) covariance(a, b) += 1.0;
    }
  }
  const Whitening whitening(observations, Sensor::gyro_x, noise, std::vector<bool>(observations.rows.size(), true));
  const Eigen::MatrixXd half = whitening.apply(covariance);
  const Eigen::MatrixXd white = whitening.apply(half.transpose());
  EXPECT_LT((white - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-10);
}

}  // namespace
}  // namespace soak::calib::gap
