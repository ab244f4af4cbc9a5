// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/outside_the_mean.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/gap/report/gap_report.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Moment;
using made_up::Plan;

TEST(OffNeighbours, IsNothingForACubicAndTheHeightOfASpike) {
  std::vector<double> level_c;
  Eigen::VectorXd levels(9);
  for (Eigen::Index k = 0; k < 9; ++k) {
    const double c = -20.0 + 5.0 * static_cast<double>(k) + (k == 3 ? 0.4 : 0.0);
    level_c.push_back(c);
    levels(k) = 1.0 - 0.2 * c + 0.01 * c * c - 0.0003 * c * c * c;
  }
  Eigen::VectorXd off = off_neighbours(level_c, levels);
  EXPECT_TRUE(std::isnan(off(0)) && std::isnan(off(1)) && std::isnan(off(7)) && std::isnan(off(8)));
  for (Eigen::Index k = 2; k < 7; ++k) EXPECT_NEAR(off(k), 0.0, 1e-12);
  levels(4) += 2.5;
  off = off_neighbours(level_c, levels);
  EXPECT_NEAR(off(4), 2.5, 1e-12);
}

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

TEST(NarrowBump, IsNotTestableWithSevenPlateaus) {
  const GapReport report = find_gap(made_up::campaign(Plan{}, made_up::nothing()), 1);
  EXPECT_TRUE(std::any_of(report.not_testable.begin(), report.not_testable.end(),
                          [](const NotTestable& entry) { return entry.name == "narrow_bump"; }));
}

}  // namespace
}  // namespace soak::calib::gap
