// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/run_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "hal/sim/campaign/simulated_run.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

using calib::Sweep;

std::string labels_of(int run) {
  std::string labels;
  for (const calib::Position& position : position_order(run)) labels += position.label;
  return labels;
}

TEST(RunPlan, VisitsTheTurningPlateauOnceAndTheStartTwice) {
  const auto points = campaign_set_points(test::shipped_config());
  ASSERT_EQ(points.size(), 41U);
  EXPECT_EQ(points.front(), (SetPoint{-30.0, Sweep::up}));
  EXPECT_EQ(points[20], (SetPoint{70.0, Sweep::up}));
  EXPECT_EQ(points[21], (SetPoint{65.0, Sweep::down}));
  EXPECT_EQ(points.back(), (SetPoint{-30.0, Sweep::down}));
}

TEST(RunPlan, VerifiesInTheMiddleBetweenPlateausBothWays) {
  const auto points = verification_set_points(test::shipped_config());
  ASSERT_EQ(points.size(), 39U);
  EXPECT_EQ(points.front(), (SetPoint{-27.5, Sweep::up}));
  EXPECT_EQ(points[19], (SetPoint{67.5, Sweep::up}));
  EXPECT_EQ(points[20], (SetPoint{62.5, Sweep::down}));
  EXPECT_EQ(points.back(), (SetPoint{-27.5, Sweep::down}));
}

TEST(RunPlan, TakesThePositionsInAnotherOrderInEachOfSixRunsWithOppositesAdjacent) {
  std::set<std::string> orders;
  for (int run = 1; run <= 6; ++run) {
    orders.insert(labels_of(run));
    const auto order = position_order(run);
    std::set<std::string> seen;
    for (std::size_t i = 0; i < order.size(); i += 2) {
      EXPECT_EQ(order[i].label[1], order[i + 1].label[1]) << labels_of(run);
      EXPECT_NE(order[i].label[0], order[i + 1].label[0]) << labels_of(run);
      seen.insert({order[i].label, order[i + 1].label});
    }
    EXPECT_EQ(seen.size(), 6U);
  }
  EXPECT_EQ(orders.size(), 6U);
}

TEST(RunPlan, RisesInTimeAndHasTheRowsThatWereAskedFor) {
  CampaignConfig config = test::shipped_config();
  config.rows_per_position = 7;
  const RunPlan plan = plan_run(config, campaign_set_points(config), 1);
  std::size_t in_position = 0;
  for (std::size_t i = 0; i < plan.rows.size(); ++i) {
    in_position += plan.rows[i].position >= 0 ? 1 : 0;
    if (i > 0) {
      EXPECT_GT(plan.rows[i].t_s, plan.rows[i - 1].t_s);
    }
  }
  EXPECT_EQ(in_position, 41U * 6U * 7U);
  EXPECT_EQ(plan.rows.size(), 41U * (6U * 7U + 5U * 5U) + 40U * 8U);
  EXPECT_EQ(plan.rows.front().t_s, 0.0);
}

TEST(RunPlan, SettlesWithinThreeTenthsOfADegreeAndHoldsWithinFiveHundredths) {
  const CampaignConfig config = test::shipped_config();
  for (int run = 1; run <= 20; ++run) {
    const RunPlan plan = plan_run(config, campaign_set_points(config), run);
    const RunTemperature temperature(config, plan.visits, static_cast<std::uint64_t>(run));
    for (std::size_t visit = 0; visit < plan.visits.size(); ++visit) {
      const double first_c = temperature.unit_c(visit, plan.visits[visit].t_soak_s);
      const double last_c = temperature.unit_c(visit, plan.visits[visit].t_end_s);
      EXPECT_LE(std::abs(first_c - plan.visits[visit].set_point.temp_c), 0.3);
      EXPECT_LE(std::abs(last_c - plan.visits[visit].set_point.temp_c), 0.3);
      EXPECT_LE(std::abs(last_c - first_c), 0.05);
      if (visit > 0) {
        EXPECT_NEAR(temperature.unit_c(visit, plan.visits[visit].t_change_s),
                    temperature.unit_c(visit - 1, plan.visits[visit].t_change_s), 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace soak::hal::sim
