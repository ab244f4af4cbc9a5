// SPDX-License-Identifier: Apache-2.0
// What `find_gap` says of cycles in one attitude without plateaus, with an effect of the test's own in them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>

#include "calib/gap/report/gap_report.h"
#include "tests/gap/made_up_ramps.h"
#include "tests/long_tests.h"

namespace soak::calib::gap {
namespace {

using made_up::kStep_s;
using made_up::of_time;
using made_up::play;
using made_up::Ramp;
using made_up::RampEffect;
using made_up::RampPlan;
using made_up::ramps;

RampEffect no_effect() {
  return [](const Ramp& ramp, Sensor) { return std::vector<double>(ramp.t_s.size(), 0.0); };
}

/// What a first-order element at the first temperature makes of a temperature history.
std::vector<double> behind(const Ramp& ramp, double tau_s) {
  std::vector<double> result;
  double element_c = ramp.temp_c.front();
  for (const double c : ramp.temp_c) result.push_back(element_c += (c - element_c) * kStep_s / tau_s);
  return result;
}

/// A gradient that a second node leaves behind.
RampEffect gradient(double size) {
  return [=](const Ramp& ramp, Sensor) {
    std::vector<double> result = behind(ramp, 150.0);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = size * (ramp.temp_c[i] - result[i]) / 7.0;
    return result;
  };
}

RampEffect walk(double size, std::uint64_t seed) {
  return [=](const Ramp& ramp, Sensor sensor) {
    base::Random random(1000 * seed + index_of(sensor));
    std::vector<double> result;
    double value = 0.0;
    for (std::size_t i = 0; i < ramp.t_s.size(); ++i) {
      result.push_back(value += size * random.gaussian() * std::sqrt(kStep_s / 2000.0));
    }
    return result;
  };
}

/// Water that condenses in the cold and dries slowly in the warmth: follows the temperature history, and is no entry of
/// the library.
RampEffect damp(double size) {
  return [=](const Ramp& ramp, Sensor) {
    std::vector<double> result;
    double water = 0.0;
    for (const double c : ramp.temp_c) {
      water += kStep_s * ((c < 5.0 ? 1.0 / 300.0 : 0.0) - water / (c > 15.0 ? 1500.0 : 15000.0));
      result.push_back(0.5 * size * water);
    }
    return result;
  };
}

bool is_among(const std::vector<NamedEffect>& entries, std::string_view name) {
  return std::any_of(entries.begin(), entries.end(), [&](const NamedEffect& entry) {
    return entry.effect->name == name || std::any_of(entry.rivals.begin(), entry.rivals.end(),
                                                     [&](const Rival& rival) { return rival.effect->name == name; });
  });
}

/// Of twelve seeds, three or four branches: how often the truth was named first, was in the set named, was named or
/// suspected, and how often a set without it was named.
struct Tally {
  int first = 0;
  int within = 0;
  int seen = 0;
  int wrong = 0;
  int none = 0;
  std::string other;
};

template <class Make>
Tally tally(std::string_view truth, Make make) {
  Tally count;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    RampPlan plan;
    plan.seed = seed;
    plan.branches = seed % 3 == 0 ? 4 : 3;
    plan.cools_first = seed % 2 == 0;
    const GapReport report = find_gap(make(plan), 1);
    EXPECT_EQ(report.judged_on, JudgedOn::branches);
    EXPECT_EQ(report.effects.empty(), report.conclusion != Conclusion::named);
    if (report.conclusion == Conclusion::none) ++count.none;
    if (is_among(report.effects, truth) || is_among(report.suspects, truth)) ++count.seen;
    if (report.conclusion != Conclusion::named) {
      count.other += std::string(name_of(report.conclusion)) + ": " + report.reason + "\n";
      continue;
    }
    if (report.effects.front().effect->name == truth) ++count.first;
    if (is_among(report.effects, truth)) {
      ++count.within;
    } else {
      ++count.wrong;
      count.other += "FALSE " + std::string(report.effects.front().effect->name) + "\n";
    }
  }
  return count;
}

void expect_mostly_named(std::string_view truth, const Tally& count) {
  EXPECT_EQ(count.wrong, 0) << truth << "\n" << count.other;
  EXPECT_GE(count.within, 9) << truth << "\n" << count.other;
  EXPECT_GE(count.first, 7) << truth << "\n" << count.other;
}

TEST(Branches, SayNoneWhereACurveIsAllThereIs) {
  const Tally count = tally("", [](const RampPlan& plan) { return ramps(plan, no_effect()); });
  EXPECT_EQ(count.wrong, 0) << count.other;
  EXPECT_GE(count.none, 11) << count.other;
}

TEST(Branches, NameALagOrASetWithIt) {
  expect_mostly_named("sensor_lag", tally("sensor_lag", [](const RampPlan& plan) {
                        return ramps(plan, no_effect(), [](const Ramp& ramp) { return behind(ramp, 75.0); });
                      }));
}

TEST(Branches, NameHysteresisOrASetWithIt) {
  expect_mostly_named("thermal_hysteresis",
                      tally("thermal_hysteresis", [](const RampPlan& plan) { return ramps(plan, play(8.0, 5.0)); }));
}

// The library's memory fades with the way, a rod's ends: with a wide play little is named, and nothing falsely.
TEST(Branches, SuspectHysteresisOfAnotherForm) {
  const Tally count = tally("thermal_hysteresis", [](const RampPlan& plan) { return ramps(plan, play(8.0, 12.0)); });
  EXPECT_EQ(count.wrong, 0) << count.other;
  EXPECT_GE(count.seen, 11) << count.other;
}

TEST(Branches, NameAGradientOrASetWithIt) {
  expect_mostly_named("temperature_rate",
                      tally("temperature_rate", [](const RampPlan& plan) { return ramps(plan, gradient(10.0)); }));
}

TEST(Branches, NeverNameADrift) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RampPlan plan;
    plan.seed = seed;
    const GapReport report = find_gap(ramps(plan, of_time([](double t_s) { return t_s / 200.0; })), 1);
    EXPECT_EQ(report.conclusion, Conclusion::unknown) << report.reason;
    ASSERT_TRUE(report.residual_structure) << report.reason;
    EXPECT_EQ(report.residual_structure->axis, "time of the recording");
    EXPECT_EQ(report.residual_structure->kind, StructureKind::drift_in_run);
  }
}

TEST(Branches, NameNothingThatTheLibraryDoesNotKnow) {
  SOAK_LONG_TEST();
  const std::map<std::string, std::function<RampEffect(const RampPlan&)>> kinds = {
      {"random walk", [](const RampPlan& plan) { return walk(15.0, plan.seed); }},
      {"wave in time",
       [](const RampPlan& plan) {
         const double phase = static_cast<double>(plan.seed);
         return of_time([=](double t_s) { return 15.0 * std::sin(t_s / 380.0 + phase); });
       }},
      {"jumps", [](const RampPlan& plan) {
         const double at_s = 600.0 + 300.0 * static_cast<double>(plan.seed);
         return of_time([=](double t_s) { return t_s > at_s && t_s < at_s + 1300.0 ? 15.0 : 0.0; });
       }}};
  for (const auto& [kind, make] : kinds) {
    const Tally count = tally("", [&](const RampPlan& plan) { return ramps(plan, make(plan)); });
    EXPECT_EQ(count.wrong, 0) << kind << "\n" << count.other;
    EXPECT_EQ(count.none, 0) << kind;
  }
  // The damp follows the temperature history as a memory does; once in twelve is what twelve seeds cannot tell from a
  // fifth.
  const Tally count = tally("", [](const RampPlan& plan) { return ramps(plan, damp(15.0)); });
  EXPECT_LE(count.wrong, 1) << count.other;
}

TEST(Branches, ClosedFractionIsOfBranchesLeftOut) {
  RampPlan plan;
  plan.branches = 4;
  const GapReport report = find_gap(ramps(plan, play(8.0, 5.0)), 1);
  ASSERT_EQ(report.conclusion, Conclusion::named) << report.reason;
  for (const Sensor sensor : report.effects.front().sensors) {
    const auto& gap = report.gap[index_of(sensor)];
    ASSERT_TRUE(gap && gap->closed_fraction);
    EXPECT_GT(*gap->closed_fraction, 0.7);
    EXPECT_LT(gap->after_rms, gap->before_rms);
    EXPECT_GT(report.effects.front().heldout_gain, 0.5);
    EXPECT_LT(report.effects.front().p_adjusted, kGate);
  }
}

TEST(Branches, OfSeveralRunsHaveOffsetsThatAreNoGap) {
  // The last run has one branch only: nothing but itself knows its offset.
  LoggedCampaign campaign;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    RampPlan plan;
    plan.seed = seed;
    plan.branches = seed == 3 ? 1 : 3;
    LoggedRun run = ramps(plan, no_effect()).runs.front();
    run.run.label = "R" + std::to_string(seed);
    for (Block& block : run.run.segments.front().blocks) {
      for (const Sensor sensor : kSensors) {
        block.sensor[index_of(sensor)].mean +=
            30.0 * static_cast<double>(seed) * (is_gyro(sensor) ? plan.gyro : plan.accel);
      }
    }
    campaign.runs.push_back(std::move(run));
  }
  const GapReport report = find_gap(campaign, 1);
  EXPECT_EQ(report.conclusion, Conclusion::none) << report.reason;
  for (const auto& gap : report.gap) {
    ASSERT_TRUE(gap);
    EXPECT_LT(gap->before_rms, 1.5 * gap->floor_rms);
  }
  campaign.runs[1] = campaign.runs[0];
  EXPECT_EQ(find_gap(campaign, 1).conclusion, Conclusion::cannot_judge);
}

TEST(Branches, OfOneCannotJudge) {
  RampPlan plan;
  plan.branches = 1;
  const GapReport report = find_gap(ramps(plan, no_effect()), 1);
  EXPECT_EQ(report.conclusion, Conclusion::cannot_judge);
}

// A station labels what it records between plateaus "ramp", an imported recording has no label or "soak".
TEST(Branches, AreJudgedAlikeWhateverTheRecorderCallsThem) {
  LoggedCampaign campaign = ramps({}, play(8.0, 5.0));
  const GapReport as_soak = find_gap(campaign, 1);
  campaign.runs.front().run.segments.front().phase = Phase::ramp;
  const GapReport as_ramp = find_gap(campaign, 1);
  EXPECT_EQ(name_of(as_ramp.conclusion), name_of(as_soak.conclusion)) << as_ramp.reason;
  EXPECT_NE(as_ramp.conclusion, Conclusion::cannot_judge) << as_ramp.reason;
  EXPECT_EQ(as_ramp.effects.size(), as_soak.effects.size());
}

TEST(Branches, SayWhatOneAttitudeCannotTest) {
  const GapReport report = find_gap(ramps({}, no_effect()), 1);
  for (const char* name : {"g_sensitivity", "earth_rate", "cross_axis", "fixture_tilt", "scale_nonlinearity",
                           "supply_sensitivity", "vibration_rectification", "aging_drift"}) {
    EXPECT_TRUE(std::any_of(report.not_testable.begin(), report.not_testable.end(), [&](const NotTestable& entry) {
      return entry.name == name && !entry.why.empty();
    })) << name;
  }
}

TEST(Branches, SurviveReadingsThatAreMissingConstantOrClipped) {
  LoggedCampaign campaign = ramps({}, no_effect());
  campaign.samples[2].at_rails = 20;
  for (Block& block : campaign.runs[0].run.segments[0].blocks) {
    block.sensor[0].mean = 0.001;
    block.sensor[1].count = 0;
    if (block.t_s < 300.0) block.sensor[3].mean = std::nan("");
  }
  const GapReport report = find_gap(campaign, 1);
  EXPECT_EQ(report.conclusion, Conclusion::none) << report.reason;
  EXPECT_FALSE(report.gap[0] || report.gap[1] || report.gap[2]);
  EXPECT_TRUE(report.gap[3] && report.gap[4] && report.gap[5]);
}

TEST(Branches, OfACoarseThermometerCannotJudge) {
  LoggedCampaign campaign = ramps({}, no_effect());
  campaign.thermometer.step = 0.5;
  EXPECT_EQ(find_gap(campaign, 1).conclusion, Conclusion::cannot_judge);
}

}  // namespace
}  // namespace soak::calib::gap
