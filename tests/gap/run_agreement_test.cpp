// SPDX-License-Identifier: Apache-2.0
// Runs of another unit, or recorded otherwise, must be told by name and give no effect; what one unit does must not
// pass for two.
#include "calib/gap/base/run_agreement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "calib/gap/report/gap_report.h"
#include "tests/errors.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Hidden;
using made_up::Moment;
using made_up::Plan;
using made_up::unit_of;

Plan plan_of(int runs, std::uint64_t seed = 1) {
  Plan plan;
  plan.runs = runs;
  plan.seed = seed;
  return plan;
}

/// The curve of another unit, in some of the runs.
Hidden another_unit_in(std::set<int> runs) {
  return [runs = std::move(runs)](Sensor sensor, const Moment& m) {
    if (!runs.contains(m.run)) return 0.0;
    const double k = static_cast<double>(index_of(sensor)) + 1.0;
    const double size = is_gyro(sensor) ? 0.004 : 0.15;
    const double curve =
        size * (std::tanh((m.temp_c - 60.0 + 12.0 * k) / 25.0) + 0.2 * std::cos(m.temp_c / (10.0 + k)));
    return curve - made_up::bias(sensor, m.temp_c);
  };
}

void expect_no_judgement(const GapReport& report, std::initializer_list<std::string_view> names) {
  EXPECT_EQ(name_of(report.conclusion), "cannot_judge") << report.reason;
  EXPECT_TRUE(report.effects.empty() && report.suspects.empty());
  EXPECT_TRUE(base::mentions_in_order(report.reason, names));
}

/// Why the runs would not be of one unit; empty where they are.
std::string disagreement_of(const LoggedCampaign& campaign) {
  const Observations observations = observe(campaign);
  const TemperatureHistory history(campaign, observations);
  return disagreement(CampaignModel(observations, history)).value_or("");
}

void expect_one_unit(const char* what, const Plan& plan, const Hidden& hidden) {
  EXPECT_EQ(disagreement_of(made_up::campaign(plan, hidden)), "") << what << ", seed " << plan.seed;
}

/// `change` of each block of a run.
template <class Change>
void change_blocks(LoggedCampaign& campaign, std::size_t run, Change change) {
  for (Segment& segment : campaign.runs[run].run.segments) {
    for (Block& block : segment.blocks) change(block);
  }
}

TEST(RunAgreement, AnotherUnitsRunIsNamedFromThreeRunsOn) {
  for (int runs = 3; runs <= 6; ++runs) {
    const GapReport report = find_gap(made_up::campaign(plan_of(runs), another_unit_in({1})), 1);
    expect_no_judgement(report, {"R2"});
    EXPECT_FALSE(base::mentions(report.reason, {"R1"})) << report.reason;
  }
}

TEST(RunAgreement, OfTwoRunsOneMayBeOfAnotherUnit) {
  const GapReport report = find_gap(made_up::campaign(plan_of(2), another_unit_in({1})), 1);
  expect_no_judgement(report, {"R1", "R2"});
}

/// Leaves the way up only.
LoggedCampaign one_way(LoggedCampaign campaign) {
  for (LoggedRun& run : campaign.runs) {
    std::erase_if(run.run.segments, [](const Segment& segment) { return segment.sweep == Sweep::down; });
  }
  return campaign;
}

TEST(RunAgreement, RunsThatGoOneWayOnlyAreComparedToo) {
  for (const int runs : {2, 3, 6}) {
    Plan plan = plan_of(runs, 40 + static_cast<std::uint64_t>(runs));
    plan.visit_share = 5.0;
    EXPECT_EQ(disagreement_of(one_way(made_up::campaign(plan, made_up::nothing()))), "") << runs;
    EXPECT_NE(disagreement_of(one_way(made_up::campaign(plan, another_unit_in({1})))), "") << runs;
  }
}

TEST(RunAgreement, TwoOrThreeOfSixRunsAreTold) {
  expect_no_judgement(find_gap(made_up::campaign(plan_of(6), another_unit_in({1, 4})), 1), {"R2", "R5"});
  expect_no_judgement(find_gap(made_up::campaign(plan_of(6), another_unit_in({3, 4, 5})), 1),
                      {"R1", "R2", "R3", "R4", "R5", "R6"});
}

TEST(RunAgreement, TheLockedRunIsHeldToIt) {
  Plan plan = plan_of(9);
  plan.levels = 5;
  expect_no_judgement(find_gap(made_up::campaign(plan, another_unit_in({8})), 1), {"R9"});
}

TEST(RunAgreement, SwappedAxesOfOneRunAreTold) {
  LoggedCampaign campaign = made_up::campaign(plan_of(6), made_up::nothing());
  change_blocks(campaign, 4, [](Block& block) { std::swap(block.sensor[0], block.sensor[1]); });
  const GapReport report = find_gap(campaign, 1);
  expect_no_judgement(report, {"R5"});
  EXPECT_TRUE(base::mentions(report.reason, {"gyro_x", "gyro_y"}));
}

TEST(RunAgreement, TurnedSignsAndOtherUnitsOfMeasurementAreTold) {
  for (const double factor : {-1.0, 180.0 / 3.14159265358979}) {
    LoggedCampaign campaign = made_up::campaign(plan_of(6), made_up::nothing());
    change_blocks(campaign, 2, [&](Block& block) {
      for (std::size_t s = 0; s < 3; ++s) {
        block.sensor[s].mean *= factor;
        block.sensor[s].variance *= factor * factor;
      }
    });
    expect_no_judgement(find_gap(campaign, 1), {"R3"});
  }
}

TEST(RunAgreement, AThermometerInFahrenheitOrStuckIsTold) {
  const auto fahrenheit = [](double c) { return 1.8 * c + 32.0; };
  const auto stuck = [](double) { return 25.0; };
  for (const int runs : {2, 6}) {
    for (const bool is_stuck : {false, true}) {
      LoggedCampaign campaign = made_up::campaign(plan_of(runs), made_up::nothing());
      const auto wrong = [&](double c) { return is_stuck ? stuck(c) : fahrenheit(c); };
      change_blocks(campaign, 1, [&](Block& block) {
        block.temp_c = wrong(block.temp_c);
        block.sensor_temp_c.fill(block.temp_c);
      });
      for (double& c : campaign.runs[1].log.temp_c) c = wrong(c);
      const GapReport report = find_gap(campaign, 1);
      expect_no_judgement(report, {"R2", "thermometer"});
      EXPECT_EQ(bool(base::mentions(report.reason, {"R1"})), runs == 2) << report.reason;
    }
  }
}

TEST(RunAgreement, NothingHiddenIsOneUnitWhateverTheScatter) {
  for (std::uint64_t seed = 1; seed <= made_up::fewer_under_sanitizers(60); ++seed) {
    Plan plan = plan_of(2 + static_cast<int>(seed % 5), seed);
    plan.visit_share = seed % 2 == 0 ? 0.5 : 4.0;
    plan.placement_share = seed % 3 == 0 ? 0.5 : 3.0;
    plan.run_share = 100.0;
    plan.levels = seed % 4 == 0 ? 3 : 7;
    expect_one_unit("nothing", plan, made_up::nothing());
  }
}

/// An effect that is stronger in one run than in the next by up to half.
Hidden uneven(Hidden hidden, double times) {
  constexpr std::array kStrength = {1.4, 0.6, 1.0, 1.3, 0.7, 1.0};
  return [=, hidden = std::move(hidden)](Sensor sensor, const Moment& m) {
    return times * kStrength.at(static_cast<std::size_t>(m.run) % kStrength.size()) * hidden(sensor, m);
  };
}

TEST(RunAgreement, StrongEffectsThatVaryAreOneUnit) {
  for (const int runs : {2, 3, 6}) {
    const Plan plan = plan_of(runs, 10 + static_cast<std::uint64_t>(runs));
    for (const double times : {1.2, 5.0, 20.0}) {
      expect_one_unit("hysteresis", plan, uneven(made_up::hysteresis(plan), times));
      expect_one_unit(
          "supply", plan,
          uneven([&](Sensor sensor, const Moment& m) { return unit_of(plan, sensor) * (m.supply_v - 5.0) / 0.05; },
                 times));
      expect_one_unit("compressor", plan,
                      uneven([&](Sensor sensor, const Moment& m) { return unit_of(plan, sensor) * m.duty; }, times));
      expect_one_unit("warm-up", plan,
                      uneven([&](Sensor sensor,
                                 const Moment& m) { return 8.0 * unit_of(plan, sensor) * std::exp(-m.t_s / 1500.0); },
                             times));
      expect_one_unit(
          "g", plan,
          uneven([&](Sensor sensor,
                     const Moment& m) { return is_gyro(sensor) ? plan.gyro_block * (m.up[0] - m.up[2]) : 0.0; },
                 times));
      expect_one_unit("ageing", plan, [&](Sensor sensor, const Moment& m) {
        return times * 20.0 * unit_of(plan, sensor) * (100000.0 * m.run + m.t_s) / 500000.0;
      });
      expect_one_unit(
          "creep", plan,
          uneven([&](Sensor sensor,
                     const Moment& m) { return unit_of(plan, sensor) * std::exp(-m.in_placement_s / 60.0); },
                 times));
    }
    Plan hasty = plan;
    hasty.soak_s = 700.0;
    expect_one_unit("lag", hasty, made_up::lag({160.0, 310.0, 240.0, 190.0, 280.0, 250.0}));
  }
}

TEST(RunAgreement, MountingsThatLeanAreOneUnit) {
  for (const double angle_rad : {4e-4, 4e-3, 0.05}) {
    for (const int runs : {2, 3, 6}) {
      base::Random random(8);
      std::array<Vector3, 6> lean{};
      for (Vector3& angles : lean) {
        for (double& angle : angles) angle = angle_rad * random.gaussian();
      }
      expect_one_unit("tilt", plan_of(runs), [&](Sensor sensor, const Moment& m) {
        if (is_gyro(sensor)) return 0.0;
        const Vector3& a = lean.at(static_cast<std::size_t>(m.run));
        const std::size_t i = axis_of(sensor);
        return 9.81 * (m.up[(i + 1) % 3] * a[(i + 2) % 3] - m.up[(i + 2) % 3] * a[(i + 1) % 3]);
      });
    }
  }
}

TEST(RunAgreement, ACoarseThermometerALostVisitAndWrongLabelsAreOneUnit) {
  for (const int runs : {2, 3, 6}) {
    LoggedCampaign campaign = made_up::campaign(plan_of(runs, 31), made_up::nothing());
    auto& segments = campaign.runs[0].run.segments;
    std::erase_if(segments, [](const Segment& segment) { return segment.key.visit == 4; });
    // Two labels of a visit exchanged: accelerometers read 2 g off.
    for (Segment& segment : campaign.runs[1].run.segments) {
      if (segment.key.visit != 2) continue;
      if (segment.key.position == "+Z") segment.position = position_named("-Z");
      if (segment.key.position == "-Z") segment.position = position_named("+Z");
    }
    EXPECT_EQ(disagreement_of(campaign), "") << runs;
    for (std::size_t run = 0; run < campaign.runs.size(); ++run) {
      change_blocks(campaign, run, [](Block& block) {
        block.temp_c = std::round(block.temp_c);
        block.sensor_temp_c.fill(block.temp_c);
      });
    }
    EXPECT_EQ(disagreement_of(campaign), "") << runs << ", whole degrees";
  }
}

}  // namespace
}  // namespace soak::calib::gap
