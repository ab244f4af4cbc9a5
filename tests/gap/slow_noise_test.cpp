// SPDX-License-Identifier: Apache-2.0
// What a report lists of a bias that wanders while units run.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "calib/gap/report/gap_report.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Hidden;
using made_up::Plan;
using made_up::unit_of;

GapReport find_gap_in(const Plan& plan, const Hidden& hidden) { return find_gap(made_up::campaign(plan, hidden), 1); }

TEST(SlowNoise, IsListedSensorBySensorWithItsSize) {
  Plan plan;
  plan.seed = 2;
  const std::vector<double> taus_s = {360.0, 3600.0, 36000.0};
  const LoggedCampaign campaign = made_up::campaign(plan, made_up::wander(plan, 1.25, taus_s, plan.seed));
  const GapReport report = find_gap(campaign, 1);
  ASSERT_EQ(report.slow_noise.size(), kSensorCount);
  const Observations observations = observe(campaign);
  for (const SensorWander& wander : report.slow_noise) {
    std::vector<GaussMarkov> truth;
    for (const double tau_s : taus_s)
      truth.push_back({tau_s, 1.25 * unit_of(plan, wander.sensor) / std::sqrt(static_cast<double>(taus_s.size()))});
    const double expected = std::sqrt(wander_variance(observations, truth));
    // Six runs of a process that is hardly shorter than a run: a third.
    EXPECT_NEAR(wander.within_run / expected, 1.0, 0.35) << name_of(wander.sensor);
    EXPECT_FALSE(wander.at_rest);
  }
  // That of 6 minutes is forgotten within minutes, that of ten hours is not, and that of an hour may count as either.
  const auto share_of = [&](const std::vector<double>& some_s) {
    const auto variance = [&](const std::vector<double>& of_s) {
      std::vector<GaussMarkov> parts;
      for (const double tau_s : of_s) parts.push_back({tau_s, 1.0});
      return wander_variance(observations, parts);
    };
    return variance(some_s) / variance(taus_s);
  };
  double mean = 0.0;
  for (const SensorWander& wander : report.slow_noise) mean += wander.share_minutes / kSensorCount;
  EXPECT_GT(mean, share_of({taus_s[0]}) - 0.1);
  EXPECT_LT(mean, share_of({taus_s[0], taus_s[1]}) + 0.1);
}

/// Mean over the sensors of the share that is forgotten within minutes.
double share_within_minutes(double tau_s) {
  const Plan plan;
  const GapReport report = find_gap_in(plan, made_up::wander(plan, 1.25, {tau_s}, 5));
  EXPECT_FALSE(report.slow_noise.empty()) << tau_s << ": " << report.reason;
  double sum = 0.0;
  for (const SensorWander& wander : report.slow_noise) sum += wander.share_minutes;
  return sum / static_cast<double>(report.slow_noise.size());
}

TEST(SlowNoise, TellsWhatIsForgottenWithinMinutesFromWhatStaysForHours) {
  EXPECT_GT(share_within_minutes(600.0), 0.5);
  EXPECT_LT(share_within_minutes(20000.0), 0.5);
}

TEST(SlowNoise, IsNoneWhereNothingWanders) { EXPECT_TRUE(find_gap_in(Plan(), made_up::nothing()).slow_noise.empty()); }

TEST(SlowNoise, ComesBackFromADocument) {
  SensorWander wander{Sensor::gyro_y, 2e-5, 0.25, 0.75,
                      InstabilityAtRest{1e-5, 0.9e-5, 1.1e-5, 80.0, "rest", "R1", 7200.0}};
  const nlohmann::json document = {{"slow_noise", slow_noise_json({wander, {Sensor::accel_x, 1e-3, 1.0, 0.0}})}};
  const std::vector<SensorWander> back = slow_noise_of(document);
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0].sensor, Sensor::gyro_y);
  EXPECT_NEAR(back[0].within_run, 2e-5, 1e-19);
  ASSERT_TRUE(back[0].at_rest);
  EXPECT_NEAR(back[0].at_rest->high, 1.1e-5, 1e-19);
  EXPECT_EQ(back[0].at_rest->run, "R1");
  EXPECT_FALSE(back[1].at_rest);
  EXPECT_TRUE(slow_noise_of(nlohmann::json{{"unit", "U"}}).empty());
}

}  // namespace
}  // namespace soak::calib::gap
