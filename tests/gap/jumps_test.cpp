// SPDX-License-Identifier: Apache-2.0
// A bias that jumps: what is a step, and what jumps to and fro.
#include <gtest/gtest.h>

#include "calib/gap/report/gap_report.h"
#include "calib/gap/search/search.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Hidden;
using made_up::Moment;
using made_up::Plan;

/// A large step of one accelerometer in run R3 from `when_s` on, half of it in the block whose middle that is.
Hidden one_step(const Plan& plan, double when_s, double blocks) {
  const Hidden wandering = made_up::wander(plan, 0.5, {360.0, 3600.0, 36000.0}, 11);
  return [=](Sensor sensor, const Moment& moment) {
    const bool steps = sensor == Sensor::accel_y && moment.run == 2 && moment.t_s > when_s - 30.0;
    const double part = moment.t_s < when_s + 30.0 ? 0.5 : 1.0;
    return wandering(sensor, moment) + (steps ? part * blocks * plan.accel_block : 0.0);
  };
}

GapReport report_on(const Plan& plan, const Hidden& hidden) { return find_gap(made_up::campaign(plan, hidden), 1); }

constexpr double kVisit_s = 2880.0;  ///< soak and six placements of the plan
constexpr double kPlacement_s = 180.0;

void expect_one_step(const GapReport& report, double when_s) {
  EXPECT_EQ(name_of(report.conclusion), "unknown") << report.reason;
  ASSERT_TRUE(report.residual_structure);
  EXPECT_EQ(name_of(report.residual_structure->kind), "step");
  ASSERT_EQ(report.residual_structure->steps.size(), 1U);
  const BiasStep& step = report.residual_structure->steps.front();
  EXPECT_EQ(step.run, "R3");
  EXPECT_NEAR(step.t_s, when_s, 2.5 * kPlacement_s);
  EXPECT_NEAR(step.since_s, step.t_s - 30.0, 1e-6);
  EXPECT_NEAR(step.before_s, step.since_s - 60.0, 1e-6) << "the block before it, within the visit";
}

TEST(Jumps, AreAStepAndNoTelegraphNoiseWhereOneComesWithinAPlacement) {
  const Plan plan;
  for (const int placement : {1, 3}) {
    const double middle_s = 5.0 * kVisit_s + (placement + 0.5) * kPlacement_s;
    expect_one_step(report_on(plan, one_step(plan, middle_s, 20.0)), middle_s);
  }
}

TEST(Jumps, AreAStepAndNoTelegraphNoiseWhereOneComesAtATurnThatIsNotTried) {
  Plan plan;
  plan.levels = 9;  // 101 turns in a run: of those within visits every second is tried
  for (const int turn : {1, 3}) {
    const double when_s = 5.0 * kVisit_s + turn * kPlacement_s;
    expect_one_step(report_on(plan, one_step(plan, when_s - 30.0, 20.0)), when_s);
  }
}

}  // namespace
}  // namespace soak::calib::gap
