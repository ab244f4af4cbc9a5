// SPDX-License-Identifier: Apache-2.0
// Mechanisms that the library does not have must not pass for one that it has, nor for scatter.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "calib/gap/report/gap_report.h"
#include "calib/gap/search/detail/jumps_beside_wander.h"
#include "calib/gap/search/detail/slow_noise.h"
#include "tests/gap/gap_notes.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Hidden;
using made_up::Moment;
using made_up::Plan;
using made_up::unit_of;

GapReport report_on_one_thread(const Plan& plan, const Hidden& hidden) {
  return find_gap(made_up::campaign(plan, hidden), 1);
}

void expect_unknown(const GapReport& report, std::string_view axis, StructureKind kind) {
  EXPECT_EQ(name_of(report.conclusion), "unknown") << report.reason;
  EXPECT_TRUE(report.effects.empty());
  ASSERT_TRUE(report.residual_structure);
  EXPECT_EQ(name_of(report.residual_structure->kind), name_of(kind));
  EXPECT_EQ(report.residual_structure->axis, axis);
}

/// A step is found at the first block of the placement after it: at most a soak and a placement later, or, where noise
/// hides it, a placement earlier.
void expect_at(const BiasStep& step, double when_s) {
  EXPECT_GT(step.t_s, when_s - 200.0) << step.run << " " << name_of(step.sensor);
  EXPECT_LT(step.t_s, when_s + 2200.0) << step.run << " " << name_of(step.sensor);
}

/// State of a mechanism that all sensors of a unit share, carried from moment to moment of a run.
struct State {
  int run = -1;
  double t_s = 0.0;
  double value = 0.0;
};

TEST(Unknown, IsABiasThatJumpsToAndFro) {
  const Plan plan;
  auto next_s = std::make_shared<State>();
  auto jumps = std::make_shared<base::Random>(21);
  const GapReport report = report_on_one_thread(plan, [=](Sensor sensor, const Moment& moment) {
    if (next_s->run != moment.run) *next_s = {moment.run, moment.t_s, 1.0};
    while (next_s->t_s <= moment.t_s) {
      next_s->value = -next_s->value;
      next_s->t_s += -1500.0 * std::log(1.0 - jumps->uniform());
    }
    return sensor == Sensor::gyro_y ? 2.0 * plan.gyro_block * next_s->value : 0.0;
  });
  expect_unknown(report, "time, by jumps that no other run has", StructureKind::telegraph_noise);
  EXPECT_EQ(report.residual_structure->sensors, std::vector<Sensor>{Sensor::gyro_y});
}

TEST(Unknown, IsABiasThatStepsOnceInEachRun) {
  const Plan plan;
  base::Random random(22);
  std::array<double, 6> when_s{};
  std::array<double, 6> height{};
  for (std::size_t r = 0; r < 6; ++r) {
    when_s.at(r) = 4000.0 + 20000.0 * random.uniform();
    height.at(r) = random.uniform() < 0.5 ? -3.0 : 3.0;
  }
  const GapReport report = report_on_one_thread(plan, [&](Sensor sensor, const Moment& moment) {
    const auto r = static_cast<std::size_t>(moment.run);
    return moment.t_s > when_s.at(r) ? height.at(r) * unit_of(plan, sensor) : 0.0;
  });
  expect_unknown(report, "time, by jumps that no other run has", StructureKind::step);
  ASSERT_FALSE(report.residual_structure->steps.empty());
  for (const BiasStep& step : report.residual_structure->steps) {
    const std::size_t r = static_cast<std::size_t>(step.run.at(1) - '1');
    expect_at(step, when_s.at(r));
    EXPECT_GT(step.size * height.at(r), 0.0) << step.run << " " << name_of(step.sensor);
  }
}

TEST(Unknown, IsABiasThatStepsOnceInOneRun) {
  const Plan plan;
  const Hidden wandering = made_up::wander(plan, 0.5, {360.0, 3600.0, 36000.0}, 11);
  const GapReport report = report_on_one_thread(plan, [&](Sensor sensor, const Moment& moment) {
    const bool steps = sensor == Sensor::accel_y && moment.run == 2 && moment.t_s > 14000.0;
    return wandering(sensor, moment) + (steps ? 8.0 * plan.accel_block : 0.0);
  });
  expect_unknown(report, "time, by jumps that no other run has", StructureKind::step);
  ASSERT_EQ(report.residual_structure->steps.size(), 1U);
  const BiasStep& step = report.residual_structure->steps.front();
  EXPECT_EQ(step.run, "R3");
  EXPECT_EQ(step.sensor, Sensor::accel_y);
  expect_at(step, 14000.0);
  // The scatter of visits and placements on either side, and what the wander does meanwhile: some two blocks.
  EXPECT_NEAR(step.size, 8.0 * plan.accel_block, 3.0 * plan.accel_block);
}

// A step that is as far from the mean of its run as a wander of that size, for hours: at first the estimate of the
// wander holds it.
TEST(Unknown, IsABiasThatStepsOnceBesideAStrongWander) {
  const Plan plan;
  const Hidden wandering = made_up::wander(plan, 1.25, {360.0, 3600.0, 36000.0}, 31);
  const GapReport report = report_on_one_thread(plan, [&](Sensor sensor, const Moment& moment) {
    const bool steps = sensor == Sensor::accel_x && moment.run == 3 && moment.t_s > 13000.0;
    return wandering(sensor, moment) + (steps ? 6.5 * plan.accel_block : 0.0);
  });
  expect_unknown(report, "time, by jumps that no other run has", StructureKind::step);
  EXPECT_EQ(report.residual_structure->sensors, std::vector<Sensor>{Sensor::accel_x});
  ASSERT_FALSE(report.residual_structure->steps.empty());
  EXPECT_EQ(report.residual_structure->steps.front().run, "R4");
  expect_at(report.residual_structure->steps.front(), 13000.0);
}

TEST(Unknown, IsABiasThatJumpsToAndFroBesideAStrongWander) {
  const Plan plan;
  const Hidden wandering = made_up::wander(plan, 1.25, {360.0, 3600.0, 36000.0}, 32);
  auto next_s = std::make_shared<State>();
  auto jumps = std::make_shared<base::Random>(33);
  const GapReport report = report_on_one_thread(plan, [=](Sensor sensor, const Moment& moment) {
    if (next_s->run != moment.run) *next_s = {moment.run, moment.t_s, 1.0};
    while (next_s->t_s <= moment.t_s) {
      next_s->value = -next_s->value;
      next_s->t_s += -6000.0 * std::log(1.0 - jumps->uniform());
    }
    return wandering(sensor, moment) + (sensor == Sensor::gyro_y ? 2.5 * plan.gyro_block * next_s->value : 0.0);
  });
  expect_unknown(report, "time, by jumps that no other run has", StructureKind::telegraph_noise);
  EXPECT_EQ(report.residual_structure->sensors, std::vector<Sensor>{Sensor::gyro_y});
}

// The runs begin at other times of day.
/// A difference between heating and cooling that changes its sign every 22.5 K, as no memory of the temperature does.
double by_direction(const Moment& m, double size) {
  const bool even = std::lround((m.temp_c + 20.0) / 22.5) % 2 == 0;
  return m.heating == even ? size : -size;
}

TEST(Unknown, SaysWhatWouldLookLikeItAndWhichPlateausWouldTellWhereTheyAreFarApart) {
  Plan plan;
  plan.levels = 5;
  const GapReport report = report_on_one_thread(plan, [](Sensor, const Moment& m) { return by_direction(m, 4e-4); });
  EXPECT_EQ(name_of(report.conclusion), "unknown") << report.reason;
  for (const char* name : {"thermal_hysteresis", "temperature_rate", "sensor_lag", "10 K"}) {
    EXPECT_NE(report.reason.find(name), std::string::npos) << name << ": " << report.reason;
  }
  EXPECT_EQ(report.reason.find("no effect of the library"), std::string::npos) << report.reason;
}

TEST(Unknown, IsADailyWaveBesideABiasThatWanders) {
  const Plan plan;
  const Hidden wandering = made_up::wander(plan, 0.75, {360.0, 3600.0, 36000.0}, 12);
  expect_unknown(report_on_one_thread(plan,
                                      [&](Sensor sensor, const Moment& moment) {
                                        const double utc_s = 1.7e9 + 100000.0 * moment.run + moment.t_s;
                                        return wandering(sensor, moment) +
                                               3.0 * unit_of(plan, sensor) *
                                                   std::sin(2.0 * std::numbers::pi * utc_s / 86400.0);
                                      }),
                 "time of day", StructureKind::daily_wave);
}

TEST(Unknown, IsNotAWanderOfAllSensorsButOne) {
  for (std::uint64_t seed = 1; seed <= made_up::fewer_under_sanitizers(4); ++seed) {
    Plan plan;
    plan.seed = seed;
    const Hidden wandering = made_up::wander(plan, 1.25, {360.0, 3600.0, 36000.0}, seed);
    const GapReport report = report_on_one_thread(plan, [&](Sensor sensor, const Moment& moment) {
      return sensor == Sensor::gyro_z ? 0.0 : wandering(sensor, moment);
    });
    EXPECT_EQ(name_of(report.conclusion), "none") << report.reason;
    EXPECT_TRUE(has_note(report, "wandering_bias", {"gyro_x", "accel_z"}));
  }
}

// Bias instability and rate random walk, as every data sheet states them.
TEST(Unknown, IsNotABiasThatWanders) {
  for (std::uint64_t seed = 1; seed <= made_up::fewer_under_sanitizers(4); ++seed) {
    Plan plan;
    plan.seed = seed;
    const GapReport report = report_on_one_thread(plan, made_up::wander(plan, 1.25, {360.0, 3600.0, 36000.0}, seed));
    EXPECT_EQ(name_of(report.conclusion), "none") << report.reason;
    EXPECT_TRUE(has_note(report, "wandering_bias", {"gyro_x", "accel_z"}));
  }
}

TEST(Unknown, IsNotAnEffectBesideABiasThatWanders) {
  const Plan plan;
  const Hidden wandering = made_up::wander(plan, 1.0, {360.0, 3600.0, 36000.0}, 3);
  const GapReport report = report_on_one_thread(plan, [&](Sensor sensor, const Moment& moment) {
    const double bias = wandering(sensor, moment);
    if (!is_gyro(sensor)) return bias;
    const auto k = index_of(sensor);
    return bias + 1.5 * plan.gyro_block * (moment.up[k] - moment.up[(k + 1) % 3]);
  });
  ASSERT_EQ(name_of(report.conclusion), "named") << report.reason;
  EXPECT_EQ(report.effects[0].effect->name, "g_sensitivity");
}

TEST(Unknown, IsNotAnEffectWhoseStrengthVariesFromRunToRun) {
  const Plan plan;
  const std::array<double, 6> strength = {1.3, 0.7, 1.0, 1.2, 0.8, 1.0};
  const GapReport report = report_on_one_thread(plan, [&](Sensor sensor, const Moment& moment) {
    if (!is_gyro(sensor)) return 0.0;
    const auto k = index_of(sensor);
    return 3.0 * plan.gyro_block * strength.at(static_cast<std::size_t>(moment.run)) *
           (moment.up[k] - moment.up[(k + 1) % 3]);
  });
  EXPECT_EQ(name_of(report.conclusion), "named") << report.reason;
  ASSERT_FALSE(report.effects.empty());
  EXPECT_EQ(report.effects[0].effect->name, "g_sensitivity");
}

// Six runs hardly tell the variance of a process slower than a run. A smaller one with two levels that are never left
// must not pass for jumps where the estimate was too large.
TEST(JumpsBesideWander, AreNotSeenInAWanderThatIsSmallerThanEstimated) {
  constexpr double kTau_s = 2e5;
  constexpr double kBlocks = 5.0;
  for (std::uint64_t seed = 1; seed <= made_up::fewer_under_sanitizers(8); ++seed) {
    Plan plan;
    plan.seed = 40 + seed;
    const LoggedCampaign campaign = made_up::campaign(plan, made_up::wander(plan, kBlocks, {kTau_s}, plan.seed));
    const Observations observations = observe(campaign);
    const TemperatureHistory history(campaign, observations);
    KnownNoise noise;
    for (const Sensor sensor : kSensors) {
      const double unit = unit_of(plan, sensor);
      noise[index_of(sensor)] = {.block = unit,
                                 .placement = plan.placement_share * unit,
                                 .visit = plan.visit_share * unit,
                                 .visit_dof = 60.0,
                                 .wander = {{kTau_s, 2.0 * kBlocks * unit}}};
    }
    const CampaignModel model(observations, history, std::nullopt, noise);
    for (const Sensor sensor : {Sensor::gyro_x, Sensor::accel_z}) {
      EXPECT_GT(chance_of_jumps_beside_wander(model, sensor), 0.003) << "seed " << plan.seed;
    }
  }
}

// The gate is 0.003: of sixty campaigns none should be above it.
TEST(SlowNoise, IsNotSeenInScatterWithoutMemory) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Plan plan;
    plan.seed = 1000 + seed;
    plan.runs = seed % 3 == 0 ? 3 : 6;
    plan.visit_share = seed % 2 == 0 ? 0.5 : 2.0;
    plan.placement_share = plan.visit_share;
    const LoggedCampaign campaign = made_up::campaign(plan, made_up::nothing());
    const Observations observations = observe(campaign);
    const TemperatureHistory history(campaign, observations);
    EXPECT_FALSE(slow_noise(CampaignModel(observations, history), {})) << "seed " << plan.seed;
  }
}

}  // namespace
}  // namespace soak::calib::gap
