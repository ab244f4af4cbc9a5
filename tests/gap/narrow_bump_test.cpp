// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/outside_the_mean.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calib/gap/report/gap_report.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Moment;
using made_up::Plan;

Plan fine_grid() {
  Plan plan;
  plan.runs = 3;
  plan.levels = 19;  // 5 K apart
  return plan;
}

TEST(NarrowBump, IsNamedWithItsHeightAndPlaceOnAFineGrid) {
  const Plan plan = fine_grid();
  const auto bump = [&](Sensor sensor, const Moment& moment) {
    const double off = (moment.temp_c - 30.0) / 1.5;
    return sensor == Sensor::gyro_z ? 8.0 * plan.gyro_block * std::exp(-off * off) : 0.0;
  };
  const GapReport report = find_gap(made_up::campaign(plan, bump), 1);
  EXPECT_EQ(name_of(report.conclusion), "named") << report.reason;
  ASSERT_EQ(report.effects.size(), 1U) << report.reason;
  EXPECT_EQ(report.effects[0].effect->name, "narrow_bump");
  EXPECT_EQ(report.effects[0].sensors, std::vector<Sensor>{Sensor::gyro_z});
  EXPECT_EQ(report.effects[0].candidate.shape.substr(0, 5), "at 30") << report.effects[0].candidate.shape;
  const double height = 8.0 * plan.gyro_block * printed_per_si(Sensor::gyro_z);
  EXPECT_NEAR(report.effects[0].magnitude.value, height, 0.15 * height);
}

TEST(NarrowBump, IsNotMadeOfACurveThatIsWavyEverywhere) {
  const Plan plan = fine_grid();
  const auto waves = [&](Sensor sensor, const Moment& moment) {
    return 8.0 * (is_gyro(sensor) ? plan.gyro_block : plan.accel_block) * std::sin(moment.temp_c / 3.0);
  };
  for (std::uint64_t seed = 1; seed <= made_up::fewer_under_sanitizers(4); ++seed) {
    Plan other = plan;
    other.seed = seed;
    const LoggedCampaign wavy = made_up::campaign(other, waves);
    const Observations observations = observe(wavy);
    const TemperatureHistory history(wavy, observations);
    EXPECT_TRUE(look_for_bump(CampaignModel(observations, history)).effects.empty()) << "seed " << seed;
    EXPECT_EQ(name_of(find_gap(made_up::campaign(other, made_up::nothing()), 1).conclusion), "none") << "seed " << seed;
  }
}

/// `curve`: over the temperature, in noises of a block.
OutsideTheMean bumps_of(const Plan& plan, const std::function<double(double temp_c)>& curve) {
  const LoggedCampaign made = made_up::campaign(
      plan, [&](Sensor sensor, const Moment& moment) { return curve(moment.temp_c) * made_up::unit_of(plan, sensor); });
  const Observations observations = observe(made);
  const TemperatureHistory history(made, observations);
  return look_for_bump(CampaignModel(observations, history));
}

TEST(NarrowBump, IsNotMadeOfAStepHoweverHighNorOfKinksOrASplineThroughKnots) {
  const std::vector<std::pair<std::string, std::function<double(double)>>> curves = {
      {"tanh", [](double c) { return 60.0 * std::tanh((c - 21.0) / 5.0); }},
      {"tanh at a plateau", [](double c) { return 60.0 * std::tanh((c - 25.0) / 5.0); }},
      {"kink", [](double c) { return 2.0 * std::max(0.0, c - 25.0); }},
      {"kink between plateaus", [](double c) { return 2.0 * std::max(0.0, c - 27.0); }},
      {"two kinks", [](double c) { return 3.0 * (std::max(0.0, c - 12.0) - std::max(0.0, c - 22.0)); }},
      {"spline", [](double c) {
         static const LevelSpline spline({-30.0, -9.0, 1.0, 9.0, 30.0, 42.0, 80.0});
         Eigen::VectorXd values(7);
         values << 10.0, -30.0, 20.0, 45.0, -15.0, 30.0, 0.0;
         return spline.weights(c).dot(values);
       }}};
  for (const auto& [name, curve] : curves) {
    const OutsideTheMean found = bumps_of(fine_grid(), curve);
    EXPECT_TRUE(found.effects.empty()) << name << " " << found.effects.front().candidate.shape;
  }
}

TEST(NarrowBump, IsFoundBesideASteepStep) {
  const OutsideTheMean found = bumps_of(fine_grid(), [](double c) {
    return 30.0 * std::tanh((c + 5.0) / 5.0) + 30.0 / (1.0 + std::pow((c - 40.0) / 2.0, 2));
  });
  ASSERT_EQ(found.effects.size(), 1U);
  EXPECT_EQ(found.effects[0].candidate.shape.substr(0, 5), "at 40") << found.effects[0].candidate.shape;
}

TEST(NarrowBump, IsATermWithHeightPlaceAndWidthBesideOthers) {
  const Plan plan = fine_grid();
  LoggedCampaign campaign = made_up::campaign(plan, [&](Sensor sensor, const Moment& moment) {
    const double off = (moment.temp_c - 30.0) / 2.0;
    return sensor == Sensor::gyro_z ? 8.0 * plan.gyro_block / (1.0 + off * off) : 0.0;
  });
  campaign.samples[index_of(Sensor::accel_y)] = {.count = 1000, .step = 0.004, .noise = 0.002};
  const GapReport report = find_gap(campaign, 1);
  const auto accepted = accepted_terms(campaign, report, {});
  ASSERT_TRUE(accepted.has_value()) << accepted.error().message;
  ASSERT_EQ(accepted->size(), 2U);
  const auto bump = std::ranges::find(*accepted, "narrow_bump", &ModelTerm::name);
  ASSERT_NE(bump, accepted->end());
  EXPECT_FALSE(bump->lab_only);
  ASSERT_EQ(bump->parts.size(), 1U);
  const TermPart& part = bump->parts[0];
  EXPECT_EQ(part.sensors, std::vector<Sensor>{Sensor::gyro_z});
  const double height = 8.0 * plan.gyro_block;
  EXPECT_NEAR(part.value("height").value_or(0.0), height, 0.25 * height);
  EXPECT_NEAR(part.value("centre_c").value_or(0.0), 30.0, 1.0);
  EXPECT_NEAR(part.value("width_c").value_or(0.0), 2.0, 1.5);
  ASSERT_EQ(part.covariance.size(), 9U);
  // What is stated to be known of the height is neither nothing nor all of it.
  EXPECT_GT(std::sqrt(part.covariance[0]), 0.01 * height);
  EXPECT_LT(std::sqrt(part.covariance[0]), 0.3 * height);
  EXPECT_TRUE(accepted_terms(campaign, report, {"narrow_bump"}).has_value());
}

TEST(NarrowBump, IsNotTestableWithSevenPlateaus) {
  const GapReport report = find_gap(made_up::campaign(Plan{}, made_up::nothing()), 1);
  EXPECT_TRUE(std::any_of(report.not_testable.begin(), report.not_testable.end(),
                          [](const NotTestable& entry) { return entry.name == "narrow_bump"; }));
}

}  // namespace
}  // namespace soak::calib::gap
