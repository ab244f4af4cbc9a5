// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/campaign/fine_temperature.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/gap/campaign/detail/thermal_nodes.h"
#include "calib/gap/report/gap_report.h"
#include "tests/gap/gap_notes.h"
#include "tests/gap/made_up_campaign.h"
#include "tests/long_tests.h"

namespace soak::calib::gap {
namespace {

using made_up::Plan;

LoggedCampaign refined(LoggedCampaign campaign) {
  refine_logs(campaign);
  refine_blocks(campaign);
  return campaign;
}

bool is_not_testable(const GapReport& report, const std::string& effect) {
  return std::any_of(report.not_testable.begin(), report.not_testable.end(),
                     [&](const NotTestable& other) { return other.name == effect; });
}

/// As far as two campaigns' temperatures differ, RMS about the mean difference.
double difference_c(const LoggedCampaign& a, const LoggedCampaign& b) {
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (std::size_t r = 0; r < a.runs.size(); ++r) {
    for (std::size_t s = 0; s < a.runs[r].run.segments.size(); ++s) {
      const auto& blocks = a.runs[r].run.segments[s].blocks;
      for (std::size_t k = 0; k < blocks.size(); ++k) {
        const double off = blocks[k].temp_c - b.runs[r].run.segments[s].blocks[k].temp_c;
        sum += off;
        squares += off * off;
        count += 1.0;
      }
    }
  }
  return std::sqrt(squares / count - sum * sum / (count * count));
}

TEST(FineTemperature, FollowsTheUnitWithinTheSteps) {
  const LoggedCampaign true_one = made_up::campaign({}, made_up::nothing());
  const LoggedCampaign coarse = made_up::in_whole_degrees(true_one);
  const LoggedCampaign fine = refined(coarse);
  ASSERT_TRUE(fine.fine_temperature);
  EXPECT_FALSE(fine.thermometer.step);
  EXPECT_LT(fine.fine_temperature->error_c, 0.1);
  EXPECT_GT(difference_c(coarse, true_one), 0.1);
  EXPECT_LT(difference_c(fine, true_one), 0.05);
  // In the first ten minutes the unit stands within one step, which hides where it began.
  for (std::size_t k = 60; k < fine.runs[1].log.temp_c.size(); ++k) {
    EXPECT_NEAR(fine.runs[1].log.temp_c[k], true_one.runs[1].log.temp_c[k], 0.3) << "row " << k;
  }
}

TEST(FineTemperature, OfAThermometerThatTruncatesIsRightButForAConstant) {
  const LoggedCampaign true_one = made_up::campaign({}, made_up::nothing());
  LoggedCampaign lower = true_one;
  for (LoggedRun& run : lower.runs) {
    for (double& c : run.log.temp_c) c -= 0.5;
  }
  const LoggedCampaign fine = refined(made_up::in_whole_degrees(std::move(lower)));
  ASSERT_TRUE(fine.fine_temperature);
  EXPECT_LT(difference_c(fine, true_one), 0.1);
}

/// Why no number needs the certificate of the air probe.
TEST(FineTemperature, AConstantErrorOfTheAirDropsOut) {
  SOAK_LONG_TEST();
  const LoggedCampaign coarse = made_up::in_whole_degrees(made_up::campaign({}, made_up::nothing()));
  LoggedCampaign warmer = coarse;
  for (LoggedRun& run : warmer.runs) {
    for (double& c : run.log.chamber_c) c += 0.7;
  }
  const LoggedCampaign fine = refined(coarse);
  const LoggedCampaign same = refined(std::move(warmer));
  ASSERT_TRUE(fine.fine_temperature && same.fine_temperature);
  // What a run began with is not told by a unit that stands within one step, but by how far it was from the air.
  double largest_c = 0.0;
  for (std::size_t r = 0; r < fine.runs.size(); ++r) {
    for (std::size_t k = 60; k < fine.runs[r].log.temp_c.size(); ++k) {
      largest_c = std::max(largest_c, std::abs(fine.runs[r].log.temp_c[k] - same.runs[r].log.temp_c[k]));
    }
  }
  EXPECT_LT(largest_c, 0.03);
}

TEST(FineTemperature, LetsAHysteresisBeNamed) {
  SOAK_LONG_TEST();
  const Plan plan;
  const LoggedCampaign coarse = made_up::in_whole_degrees(made_up::campaign(plan, made_up::hysteresis(plan)));
  EXPECT_TRUE(is_not_testable(find_gap(coarse, 1), "thermal_hysteresis"));
  const GapReport report = find_gap(refined(coarse), 1);
  EXPECT_FALSE(is_not_testable(report, "thermal_hysteresis"));
  ASSERT_EQ(report.effects.size(), 1U) << report.reason;
  EXPECT_EQ(report.effects.front().effect->name, "thermal_hysteresis");
  EXPECT_TRUE(has_note(report, "reconstructed_temperature", {"1 K"})) << report.reason;
  EXPECT_FALSE(has_note(report, "coarse_thermometer")) << report.reason;
}

TEST(FineTemperature, OfAUnitWithoutEffectsNamesNothing) {
  SOAK_LONG_TEST();
  for (std::uint64_t seed = 1; seed <= made_up::fewer_under_sanitizers(3); ++seed) {
    Plan plan;
    plan.seed = seed;
    const LoggedCampaign campaign = refined(made_up::in_whole_degrees(made_up::campaign(plan, made_up::nothing())));
    ASSERT_TRUE(campaign.fine_temperature);
    const GapReport report = find_gap(campaign, 1);
    EXPECT_TRUE(report.effects.empty()) << "seed " << seed << ": " << report.reason;
  }
}

/// As it was before: nothing refined, and said so.
void expect_left_alone(const LoggedCampaign& campaign) {
  const LoggedCampaign after = refined(campaign);
  EXPECT_FALSE(after.fine_temperature);
  EXPECT_EQ(after.thermometer.step, campaign.thermometer.step);
  EXPECT_EQ(after.runs[0].log.temp_c, campaign.runs[0].log.temp_c);
  EXPECT_EQ(difference_c(after, campaign), 0.0);
}

TEST(FineTemperature, LeavesACampaignAloneWhoseAirSaysNothing) {
  Plan plan;
  plan.runs = 3;
  const LoggedCampaign coarse = made_up::in_whole_degrees(made_up::campaign(plan, made_up::nothing()));
  LoggedCampaign without = coarse;
  without.runs[1].log.chamber_c.clear();
  expect_left_alone(without);
  LoggedCampaign hole = coarse;
  for (std::size_t k = 500; k < 600; ++k) hole.runs[2].log.chamber_c[k] = std::nan("");
  expect_left_alone(hole);
  LoggedCampaign unrelated = coarse;
  base::Random random(5);
  for (LoggedRun& run : unrelated.runs) {
    for (double& c : run.log.chamber_c) c = 23.0 + random.gaussian();
  }
  expect_left_alone(unrelated);
  // A log of the unit itself agrees with it perfectly, and knows no more.
  LoggedCampaign itself = coarse;
  for (LoggedRun& run : itself.runs) run.log.chamber_c = run.log.temp_c;
  expect_left_alone(itself);
}

TEST(FineTemperature, LeavesACampaignAloneWhoseUnitGoesWaysOfItsOwn) {
  Plan plan;
  plan.runs = 3;
  LoggedCampaign own = made_up::campaign(plan, made_up::nothing());
  for (LoggedRun& run : own.runs) {
    for (std::size_t k = 0; k < run.log.t_s.size(); ++k) run.log.temp_c[k] += std::sin(run.log.t_s[k] / 1500.0);
  }
  expect_left_alone(made_up::in_whole_degrees(std::move(own)));
}

TEST(FineTemperature, LeavesFineThermometersAndThoseOfSensorsAlone) {
  Plan plan;
  plan.runs = 3;
  const LoggedCampaign fine = made_up::campaign(plan, made_up::nothing());
  expect_left_alone(fine);
  LoggedCampaign several = made_up::in_whole_degrees(fine);
  several.runs[0].run.segments[3].blocks[1].sensor_temp_c[2] += 1.0;
  expect_left_alone(several);
}

TEST(IntervalLikelihood, HasTheDerivativesOfItsLogarithm) {
  constexpr double kStep = 1e-4;
  for (const double mean : {-40.0, -12.0, -2.0, -0.3, 0.0, 0.4, 3.0, 29.0, 50.0}) {
    const auto at = [](double m) { return interval_likelihood(-0.5 - m, 0.5 - m, 1.0); };
    const double slope = (at(mean + kStep).log_chance - at(mean - kStep).log_chance) / (2.0 * kStep);
    const double bend = (at(mean + kStep).score - at(mean - kStep).score) / (2.0 * kStep);
    // The asymptote beyond 30 sigma leaves out 1/l² and more of each.
    const double tolerance = std::abs(mean) > 20.0 ? 3e-3 : 1e-5;
    EXPECT_NEAR(at(mean).score, slope, tolerance * (1.0 + std::abs(slope))) << mean;
    EXPECT_NEAR(at(mean).curvature, -bend, tolerance * (1.0 + std::abs(bend))) << mean;
  }
  EXPECT_NEAR(interval_likelihood(-1.0, 1.0, 1.0).log_chance, std::log(0.682689492137086), 1e-12);
}

}  // namespace
}  // namespace soak::calib::gap
