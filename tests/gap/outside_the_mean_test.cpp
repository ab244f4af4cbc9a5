// SPDX-License-Identifier: Apache-2.0
// Effects that means do not show: which sensors, and that what a model carries is not named again.
#include "calib/gap/search/outside_the_mean.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "calib/gap/report/gap_report.h"
#include "tests/gap/gap_notes.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Plan;

/// Blocks whose variance scatters as that of 60 samples does, and grows with temperature in two sensors.
LoggedCampaign noisy_campaign(double gyro_x_per_k, double gyro_y_per_k) {
  LoggedCampaign campaign = made_up::campaign(Plan{}, made_up::nothing());
  base::Random random(5);
  for (LoggedRun& run : campaign.runs) {
    for (Segment& segment : run.run.segments) {
      for (Block& block : segment.blocks) {
        for (const Sensor sensor : kSensors) {
          const double per_k = sensor == Sensor::gyro_x ? gyro_x_per_k : sensor == Sensor::gyro_y ? gyro_y_per_k : 0.0;
          const double scatter = std::exp(std::sqrt(2.0 / 59.0) * random.gaussian());
          block.sensor[index_of(sensor)].variance *= scatter * std::exp(2.0 * per_k * (block.temp_c - 25.0));
        }
      }
    }
  }
  return campaign;
}

std::string list_of(const GapReport& report) {
  std::string names;
  for (const NamedEffect& effect : report.effects)
    names += (names.empty() ? "" : ",") + std::string(effect.effect->name);
  return names;
}

TEST(OutsideTheMean, NoiseThatGrowsIsNamedInItsSensorOnly) {
  const GapReport report = find_gap(noisy_campaign(0.03, 0.0004), 1);
  ASSERT_EQ(list_of(report), "noise_vs_temperature") << report.reason;
  EXPECT_EQ(report.effects[0].sensors, std::vector<Sensor>{Sensor::gyro_x});
  EXPECT_NEAR(report.effects[0].magnitude.value, 0.03, 0.001);
}

TEST(OutsideTheMean, NoiseThatGrowsInTwoSensorsIsNamedInBoth) {
  const GapReport report = find_gap(noisy_campaign(0.03, 0.01), 1);
  ASSERT_EQ(list_of(report), "noise_vs_temperature") << report.reason;
  EXPECT_EQ(report.effects[0].sensors, (std::vector<Sensor>{Sensor::gyro_x, Sensor::gyro_y}));
}

TEST(OutsideTheMean, RunsThatAgreeBetterThanTheirSamplesAllowAreNotBelieved) {
  LoggedCampaign campaign = made_up::campaign(Plan{}, made_up::nothing());
  for (LoggedRun& run : campaign.runs) {
    base::Random scatter(11);  // the same in all runs
    base::Random own(static_cast<std::uint64_t>(100 + (&run - campaign.runs.data())));
    for (Segment& segment : run.run.segments) {
      for (Block& block : segment.blocks) {
        for (const Sensor sensor : kSensors) {
          const double log_scatter = std::sqrt(2.0 / 59.0) * (scatter.gaussian() + 0.1 * own.gaussian());
          block.sensor[index_of(sensor)].variance *= std::exp(log_scatter);
        }
      }
    }
  }
  EXPECT_EQ(list_of(find_gap(campaign, 1)), "");
}

/// Accepts all that is named, as a model that carries it would.
void accept_all(LoggedCampaign& campaign) {
  auto accepted = accepted_terms(campaign, find_gap(campaign, 1), {});
  ASSERT_TRUE(accepted.has_value()) << accepted.error().message;
  campaign.carried = *accepted;
}

TEST(OutsideTheMean, CarriedNoiseIsNotNamedAgainUntilThereIsMoreOfIt) {
  LoggedCampaign campaign = noisy_campaign(0.03, 0.0012);
  accept_all(campaign);
  EXPECT_EQ(list_of(find_gap(campaign, 2)), "");
  LoggedCampaign worse = noisy_campaign(0.05, 0.0);
  worse.carried = campaign.carried;
  const GapReport report = find_gap(worse, 2);
  ASSERT_EQ(list_of(report), "noise_vs_temperature") << report.reason;
  EXPECT_NEAR(report.effects[0].magnitude.value, 0.02, 0.002);
}

TEST(OutsideTheMean, CarriedStepsAreNotNamedAgainUntilTheyAreCoarser) {
  LoggedCampaign campaign = made_up::campaign(Plan{}, made_up::nothing());
  SampleFacts& facts = campaign.samples[index_of(Sensor::accel_y)];
  facts = {.count = 1000, .step = 0.004, .noise = 0.002};
  accept_all(campaign);
  EXPECT_EQ(list_of(find_gap(campaign, 2)), "");
  facts.step = 0.016;
  EXPECT_EQ(list_of(find_gap(campaign, 2)), "quantization");
}

TEST(OutsideTheMean, CarriedSaturationIsNotNamedAgainButSaidOfSensorsThatItLeavesOut) {
  LoggedCampaign campaign = made_up::campaign(Plan{}, made_up::nothing());
  campaign.samples[index_of(Sensor::accel_z)] = {
      .count = 1000, .noise = 0.002, .low_rail = -9.5, .high_rail = 9.5, .at_rails = 300};
  const GapReport before = find_gap(campaign, 1);
  EXPECT_EQ(list_of(before), "saturation") << before.reason;
  accept_all(campaign);
  const GapReport after = find_gap(campaign, 2);
  EXPECT_EQ(after.conclusion, Conclusion::none) << after.reason;
  for (const GapReport* report : {&before, &after}) {
    EXPECT_FALSE(report->gap[index_of(Sensor::accel_z)]);
    EXPECT_TRUE(has_note(*report, "clipped", {"accel_z"})) << report->reason;
  }
  // Another sensor's is news.
  campaign.samples[index_of(Sensor::accel_y)] = campaign.samples[index_of(Sensor::accel_z)];
  const GapReport more = find_gap(campaign, 2);
  ASSERT_EQ(list_of(more), "saturation") << more.reason;
  EXPECT_EQ(more.effects[0].sensors, std::vector<Sensor>{Sensor::accel_y});
}

}  // namespace
}  // namespace soak::calib::gap
