// SPDX-License-Identifier: Apache-2.0
// What `find_gap` says of a cooling and a heating, which have one difference: no name, careful suspects, and how a
// suspect is accepted (docs/decisions/0032-two-branches.md).
#include <gtest/gtest.h>

#include <string>

#include "calib/gap/report/gap_report.h"
#include "tests/gap/made_up_ramps.h"

namespace soak::calib::gap {
namespace {

using made_up::of_time;
using made_up::play;
using made_up::Ramp;
using made_up::RampEffect;
using made_up::RampPlan;
using made_up::ramps;

TEST(TwoBranches, GiveNoName) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RampPlan plan;
    plan.seed = seed;
    plan.branches = 2;
    const GapReport report = find_gap(ramps(plan, play(8.0, 5.0)), 1);
    EXPECT_TRUE(report.conclusion == Conclusion::unknown || report.conclusion == Conclusion::cannot_judge)
        << report.reason;
    EXPECT_TRUE(report.effects.empty());
  }
}

// One difference is a smooth curve of temperature: a size that changes with temperature would follow whatever it is.
TEST(TwoBranches, SuspectNothingWithAPartLinearInTemperature) {
  int suspected = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    RampPlan plan;
    plan.seed = seed;
    plan.branches = 2;
    const RampEffect even = play(8.0, 5.0);
    const GapReport report = find_gap(ramps(plan,
                                            [&](const Ramp& ramp, Sensor sensor) {
                                              std::vector<double> added = even(ramp, sensor);
                                              for (std::size_t i = 0; i < added.size(); ++i)
                                                added[i] *= 1.0 + ramp.temp_c[i] / 60.0;
                                              return added;
                                            }),
                                      1);
    for (const NamedEffect& suspect : report.suspects) {
      ++suspected;
      EXPECT_EQ(suspect.candidate.shape.find("linear"), std::string::npos) << suspect.candidate.shape;
    }
  }
  EXPECT_GT(suspected, 0);
}

TEST(TwoBranches, SuspectNoMemoryWhereADriftDoesAsWell) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    RampPlan plan;
    plan.seed = seed;
    plan.branches = 2;
    const GapReport report = find_gap(ramps(plan, of_time([](double t_s) { return t_s / 100.0; })), 1);
    EXPECT_TRUE(report.effects.empty());
    for (const NamedEffect& suspect : report.suspects) EXPECT_EQ(suspect.effect->name, "aging_drift");
  }
}

TEST(TwoBranches, ASuspectIsAcceptedOnlyWhereItIsAskedFor) {
  RampPlan plan;
  plan.branches = 2;
  const LoggedCampaign campaign = ramps(plan, play(8.0, 5.0));
  const GapReport report = find_gap(campaign, 1);
  ASSERT_FALSE(report.suspects.empty()) << report.reason;
  const std::string name(report.suspects.front().effect->name);
  const auto refused = accepted_terms(campaign, report, {name});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("--suspect"), std::string::npos) << refused.error().message;
  const auto terms = accepted_terms(campaign, report, {name}, Accepted::suspected);
  ASSERT_TRUE(terms) << terms.error().message;
  ASSERT_EQ(terms->size(), 1U);
  EXPECT_EQ(terms->front().name, name);
  EXPECT_EQ(terms->front().verdict, "unknown");
  EXPECT_FALSE(accepted_terms(campaign, report, {"moisture"}, Accepted::suspected));
}

}  // namespace
}  // namespace soak::calib::gap
