// SPDX-License-Identifier: Apache-2.0
// What `find_gap` says of campaigns with an effect of the test's own in them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "calib/gap/report/gap_report.h"
#include "tests/gap/gap_notes.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Hidden;
using made_up::hysteresis;
using made_up::Moment;
using made_up::Plan;
using made_up::unit_of;

GapReport report_of(const Plan& plan, const Hidden& hidden) { return find_gap(made_up::campaign(plan, hidden), 3); }

void expect_named(const GapReport& report, std::string_view name) {
  EXPECT_EQ(name_of(report.conclusion), "named") << name << ": " << report.reason;
  ASSERT_EQ(report.effects.size(), 1U) << name << ": " << report.reason;
  EXPECT_EQ(report.effects[0].effect->name, name);
  EXPECT_LT(report.effects[0].p_adjusted, kGate);
  EXPECT_GT(report.effects[0].delta_bic, 0.0);
  EXPECT_GT(report.effects[0].heldout_gain, 0.0);
}

TEST(FindGap, SaysNoneWhereNothingIsHidden) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Plan plan;
    plan.seed = seed;
    plan.runs = seed % 2 == 0 ? 6 : 3;
    const GapReport report = report_of(plan, made_up::nothing());
    EXPECT_EQ(report.conclusion, Conclusion::none) << "seed " << seed << ": " << report.reason;
    EXPECT_TRUE(report.effects.empty());
    ASSERT_TRUE(report.detection_limit[0]);
    EXPECT_GT(*report.detection_limit[0], 0.0);
  }
}

TEST(FindGap, NamesHysteresis) {
  const Plan plan;
  const GapReport report = report_of(plan, hysteresis(plan));
  expect_named(report, "thermal_hysteresis");
  // The rod's half gap is one block's noise; the largest of the sensors' estimates.
  const auto& gap = report.gap[0];
  ASSERT_TRUE(gap && gap->closed_fraction);
  EXPECT_GT(*gap->closed_fraction, 0.7);
  EXPECT_LT(gap->after_rms, gap->before_rms);
}

/// Index of the row of a map.
std::size_t row_at(const RemainderMap& map, double temp_c, Sweep sweep) {
  const auto row = std::ranges::find_if(
      map.rows, [&](const MapRow& at) { return std::abs(at.temp_c - temp_c) < 2.0 && at.sweep == sweep; });
  EXPECT_NE(row, map.rows.end()) << temp_c << " " << name_of(sweep);
  return static_cast<std::size_t>(row - map.rows.begin());
}

// In mid-range the rod is 15 K behind either way: one block's noise above the curve when heating, below when cooling.
TEST(FindGap, DrawsTheMapOfWhatIsHidden) {
  const Plan plan;
  const GapReport report = report_of(plan, hysteresis(plan));
  ASSERT_TRUE(report.map);
  const RemainderMap& map = *report.map;
  EXPECT_EQ(map.rows.size(), 13U);  // the warmest plateau is reached one way only
  EXPECT_EQ(map.positions.size(), 6U);
  const std::size_t up = row_at(map, 25.0, Sweep::up);
  const std::size_t down = row_at(map, 25.0, Sweep::down);
  for (const Sensor sensor : kSensors) {
    const auto& part = map.sensor[index_of(sensor)];
    ASSERT_TRUE(part) << name_of(sensor);
    for (std::size_t p = 0; p < map.positions.size(); ++p) {
      const double sigma = part->sigma.at(up).at(p).value();
      const double half_gap = 0.5 * (part->before.at(up).at(p).value() - part->before.at(down).at(p).value());
      EXPECT_NEAR(half_gap, unit_of(plan, sensor), 4.0 * sigma) << name_of(sensor) << " " << map.positions[p];
      EXPECT_NEAR(part->after.at(up).at(p).value(), 0.0, 5.0 * sigma) << name_of(sensor);
    }
  }
}

TEST(FindGap, DrawsAMapOfChanceWhereNothingIsHidden) {
  const Plan plan;
  const GapReport report = report_of(plan, made_up::nothing());
  ASSERT_TRUE(report.map);
  for (const Sensor sensor : kSensors) {
    const auto& part = report.map->sensor[index_of(sensor)];
    ASSERT_TRUE(part) << name_of(sensor);
    EXPECT_TRUE(part->after.empty());
    // Three blocks, one placement, one visit, in six runs; the base takes a part of it.
    const double expected = unit_of(plan, sensor) * std::sqrt((1.0 / 3.0 + 0.25 + 0.25) / 6.0);
    std::size_t beyond = 0;
    for (std::size_t row = 0; row < part->before.size(); ++row) {
      for (std::size_t p = 0; p < part->before[row].size(); ++p) {
        const double sigma = part->sigma.at(row).at(p).value();
        EXPECT_NEAR(sigma, expected, 0.15 * expected) << name_of(sensor);
        if (std::abs(part->before[row][p].value()) > 3.0 * sigma) ++beyond;
      }
    }
    EXPECT_LE(beyond, 2U) << name_of(sensor) << " of 78 cells";
  }
}

// Where four of six runs end early, the plateaus after that are known from two: √3 less well.
TEST(FindGap, TellsHowWellEachCellOfTheMapIsKnown) {
  const Plan plan;
  const LoggedCampaign campaign = made_up::campaign(plan, made_up::nothing());
  Observations some = observe(campaign);
  int last_visit = 0;
  for (const Observation& row : some.rows) last_visit = std::max(last_visit, row.visit);
  std::erase_if(some.rows, [&](const Observation& row) { return row.run >= 2 && row.visit == last_visit; });
  const TemperatureHistory history(campaign, some);
  const RemainderMap map = remainder_map(CampaignModel(some, history), {});
  for (const Sensor sensor : kSensors) {
    const auto& part = map.sensor[index_of(sensor)];
    ASSERT_TRUE(part) << name_of(sensor);
    EXPECT_NEAR(part->sigma.back().at(0).value(), std::sqrt(3.0) * part->sigma.front().at(0).value(), 1e-12);
  }
}

TEST(FindGap, DrawsNoMapOfOneRun) {
  Plan plan;
  plan.runs = 1;
  EXPECT_FALSE(report_of(plan, made_up::nothing()).map);
}

TEST(FindGap, NamesWarmUp) {
  const Plan plan;
  expect_named(
      report_of(plan, [&](Sensor sensor,
                          const Moment& m) { return 8.0 * unit_of(plan, sensor) * std::exp(-m.t_s / 1500.0); }),
      "warmup_transient");
}

// Far off the set point the curves bend over what the elements are behind: their slope alone would give half the lag.
TEST(FindGap, SaysHowFarTheElementsLagBehindTheThermometer) {
  Plan plan;
  plan.soak_s = 700.0;
  const GapReport report = report_of(plan, made_up::lag(std::vector<double>(6, 240.0)));
  expect_named(report, "sensor_lag");
  EXPECT_NEAR(report.effects[0].magnitude.value, 240.0, 24.0);
}

TEST(FindGap, NamesALagThatIsNotTheSameInAllRuns) {
  Plan plan;
  plan.soak_s = 700.0;
  expect_named(report_of(plan, made_up::lag({160.0, 310.0, 240.0, 190.0, 280.0, 250.0})), "sensor_lag");
}

TEST(FindGap, AVisitThatWasNotLoggedLeavesALagTestable) {
  Plan plan;
  plan.soak_s = 700.0;
  LoggedCampaign campaign = made_up::campaign(plan, made_up::lag(std::vector<double>(6, 240.0)));
  auto& segments = campaign.runs[2].run.segments;
  const auto lost = [](const Segment& segment) { return segment.key.visit == 4; };
  const double begin_s = std::find_if(segments.begin(), segments.end(), lost)->t_start_s;
  std::erase_if(segments, lost);
  for (std::size_t k = 0; k < campaign.runs[2].log.t_s.size(); ++k) {
    const double t_s = campaign.runs[2].log.t_s[k];
    if (t_s > begin_s && t_s < begin_s + 1080.0) campaign.runs[2].log.temp_c[k] = std::nan("");
  }
  expect_named(find_gap(campaign, 1), "sensor_lag");
}

TEST(FindGap, NamesNothingThatOneRunAloneShows) {
  for (const double size : {2.0, 4.0, 8.0}) {
    Plan plan;
    const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
      return m.run == 3 ? size * unit_of(plan, sensor) * (m.supply_v - 5.0) / 0.05 : 0.0;
    });
    EXPECT_TRUE(report.effects.empty()) << size << ": " << report.reason;
  }
}

TEST(FindGap, NamesASupplyThatOneSensorFeels) {
  const Plan plan;
  const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
    return sensor == Sensor::accel_y ? 2.0 * plan.accel_block * (m.supply_v - 5.0) / 0.05 : 0.0;
  });
  expect_named(report, "supply_sensitivity");
  ASSERT_EQ(report.effects[0].sensors.size(), 1U);
  EXPECT_EQ(report.effects[0].sensors[0], Sensor::accel_y);
  EXPECT_NEAR(report.effects[0].magnitude.value, 2.0 * plan.accel_block / 0.05, 0.2 * 2.0 * plan.accel_block / 0.05);
}

TEST(FindGap, NamesTheCompressor) {
  const Plan plan;
  expect_named(report_of(plan, [&](Sensor sensor, const Moment& m) { return 1.5 * unit_of(plan, sensor) * m.duty; }),
               "vibration_rectification");
}

/// State that a mechanism carries from moment to moment of a run.
struct Carried {
  int run = -1;
  double t_s = 0.0;
  double value = 0.0;
  Vector3 vector{};
};

// A package that is wet again at each start, to another share: twice as fast with each 9 K, not as the library's.
TEST(FindGap, NamesWaterThatDriesOutWithinARun) {
  const Plan plan;
  const std::array<double, 6> wet = {1.0, 0.7, 0.9, 0.6, 0.8, 0.75};
  Carried water;
  double least = 1.0;
  const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
    if (water.run != m.run) water = {m.run, m.t_s, wet.at(static_cast<std::size_t>(m.run))};
    water.value *= std::exp(-(m.t_s - water.t_s) / 14400.0 * std::exp2((m.temp_c - 50.0) / 9.0));
    water.t_s = m.t_s;
    least = std::min(least, water.value);
    return 6.0 * unit_of(plan, sensor) * water.value;
  });
  expect_named(report, "moisture");
  const Sensor sensor = report.effects[0].sensors[0];
  const double moved = report.effects[0].magnitude.value / (6.0 * unit_of(plan, sensor) * printed_per_si(sensor));
  EXPECT_NEAR(moved, 0.79 - least, 0.2);
}

// A share leaves within an hour where it is hot and comes back in ten hours.
TEST(FindGap, NamesWaterThatComesBackInTheCold) {
  for (const double blocks : {4.0, 10.0}) {
    const Plan plan;
    Carried water;
    const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
      if (water.run != m.run) water = {m.run, m.t_s, 1.0};
      const double out_ps = m.temp_c > 45.0 ? 1.0 / 3600.0 : 0.0;
      const double in_ps = 1.0 / 36000.0;
      const double settled = in_ps / (in_ps + out_ps);
      water.value = settled + (water.value - settled) * std::exp(-(m.t_s - water.t_s) * (in_ps + out_ps));
      water.t_s = m.t_s;
      return blocks * unit_of(plan, sensor) * water.value;
    });
    expect_named(report, "moisture");
  }
}

TEST(FindGap, NamesAMemoryOfThePositionBefore) {
  const Plan plan;
  constexpr double kTau_s = 300.0;
  Carried memory;  // since when the unit stands as it does, and what it held then
  Vector3 stands{};
  const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
    if (std::ranges::all_of(m.up, [](double x) { return x == 0.0; })) return 0.0;  // on the way: as it stood
    if (memory.run != m.run) {
      memory = {m.run, m.t_s, 0.0, m.up};
      stands = m.up;
    }
    if (m.up != stands) {
      const double left = std::exp(-(m.t_s - memory.t_s) / kTau_s);
      for (std::size_t k = 0; k < 3; ++k) memory.vector[k] = stands[k] + (memory.vector[k] - stands[k]) * left;
      memory.t_s = m.t_s;
      stands = m.up;
    }
    if (sensor != Sensor::gyro_y) return 0.0;
    const double left = std::exp(-(m.t_s - memory.t_s) / kTau_s);
    return 3.0 * plan.gyro_block * left * (memory.vector[0] - m.up[0] - 0.5 * (memory.vector[2] - m.up[2]));
  });
  expect_named(report, "position_memory");
  EXPECT_EQ(report.effects[0].sensors, std::vector<Sensor>{Sensor::gyro_y});
}

// A gyro that feels each attitude in full only after some minutes: two names, of which the second is the creep.
TEST(FindGap, NamesTheCreepBesideAGSensitivityThatSettles) {
  const Plan plan;
  const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
    if (!is_gyro(sensor)) return 0.0;
    const double settled = 1.0 - std::exp(-m.in_placement_s / 60.0);
    return 4.0 * plan.gyro_block * settled * (m.up[0] - 0.5 * m.up[2]);
  });
  EXPECT_EQ(name_of(report.conclusion), "named") << report.reason;
  ASSERT_EQ(report.effects.size(), 2U) << report.reason;
  EXPECT_EQ(report.effects[0].effect->name, "g_sensitivity");
  EXPECT_EQ(report.effects[1].effect->name, "position_memory");
}

/// Adds to accel_x `per_k` of each kelvin that the logged air is warmer than the unit, in the mean of each block.
void add_gradient(LoggedCampaign& campaign, double per_k) {
  for (LoggedRun& run : campaign.runs) {
    const RunLog& log = run.log;
    for (Segment& segment : run.run.segments) {
      for (Block& block : segment.blocks) {
        double across_c = 0.0;
        double count = 0.0;
        for (std::size_t k = 0; k < log.t_s.size(); ++k) {
          if (std::abs(log.t_s[k] - block.t_s) > 30.0) continue;
          across_c += log.chamber_c[k] - log.temp_c[k];
          count += 1.0;
        }
        block.sensor[index_of(Sensor::accel_x)].mean += per_k * across_c / count;
      }
    }
  }
}

double swing(double t_s) { return std::sin(2.0 * std::numbers::pi * t_s / 700.0); }

// The air swings about its set point at the plateaus too, which no rate of the unit follows.
TEST(FindGap, NamesAGradientFromTheAirToTheUnit) {
  const Plan plan;
  LoggedCampaign campaign = made_up::campaign(plan, made_up::nothing());
  for (LoggedRun& run : campaign.runs) {
    for (std::size_t k = 0; k < run.log.t_s.size(); ++k) run.log.chamber_c[k] += swing(run.log.t_s[k]);
  }
  add_gradient(campaign, 2.0 * plan.accel_block);
  const GapReport report = find_gap(campaign, 1);
  expect_named(report, "temperature_gradient");
  const std::size_t strongest = index_of(Sensor::accel_x);
  for (const Sensor sensor : report.effects[0].sensors) {
    if (index_of(sensor) == strongest) continue;
    EXPECT_LT(report.effects[0].gain[index_of(sensor)], 0.02 * report.effects[0].gain[strongest]);
  }
  EXPECT_NEAR(report.effects[0].magnitude.value, 2.0 * plan.accel_block, 0.4 * plan.accel_block);
}

// A unit that warms itself and is read when it has settled: the air is 3.5 K colder, and moves by 0.3 K about that.
TEST(FindGap, NamesAGradientOfAUnitThatIsReadWhenItHasSettled) {
  const Plan plan;
  LoggedCampaign campaign = made_up::campaign(plan, made_up::nothing());
  for (LoggedRun& run : campaign.runs) {
    for (std::size_t k = 0; k < run.log.t_s.size(); ++k) {
      run.log.chamber_c[k] = run.log.temp_c[k] - 3.5 + 0.15 * swing(run.log.t_s[k]);
    }
  }
  add_gradient(campaign, 20.0 * plan.accel_block);
  expect_named(find_gap(campaign, 1), "temperature_gradient");
}

TEST(FindGap, NamesGSensitivity) {
  const Plan plan;
  const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
    return sensor == Sensor::gyro_z ? plan.gyro_block * (2.0 * m.up[0] - 1.0 * m.up[1] + 2.0 * m.up[2]) : 0.0;
  });
  expect_named(report, "g_sensitivity");
  EXPECT_EQ(report.effects[0].sensors, std::vector<Sensor>{Sensor::gyro_z});
}

// Nine parameters would be too dear for what three explain, and the rotation of the Earth nearly does.
TEST(FindGap, NamesGSensitivityAlongTheGyrosOwnAxes) {
  const Plan plan;
  const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
    constexpr std::array kShare = {1.0, 0.8, 0.5};
    return is_gyro(sensor) ? 4.6e-5 * kShare.at(axis_of(sensor)) * m.up[axis_of(sensor)] : 0.0;
  });
  expect_named(report, "g_sensitivity");
  EXPECT_NEAR(report.effects[0].magnitude.value, 4.6e-5 * 180.0 / 3.14159265358979, 4e-4);
}

TEST(FindGap, SaysThatPositionsInOneOrderLeaveAMemoryOfTheOneBeforeOpen) {
  for (const bool turned : {false, true}) {
    Plan plan;
    plan.backwards_every_other_run = turned;
    const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
      return sensor == Sensor::gyro_z ? plan.gyro_block * (2.0 * m.up[0] - 1.0 * m.up[1] + 2.0 * m.up[2]) : 0.0;
    });
    expect_named(report, "g_sensitivity");
    EXPECT_EQ(has_note(report, "position_order"), !turned) << report.reason;
  }
}

// South of the equator, with the latitude entered as north: twice the vertical part is left.
TEST(FindGap, NamesTheEarthAlsoWhereTheLatitudeHasTheWrongSign) {
  const Plan plan;
  constexpr double kEarth_rps = 7.2921e-5;
  LoggedCampaign campaign = made_up::campaign(plan, [&](Sensor sensor, const Moment& m) {
    return is_gyro(sensor) ? -kEarth_rps * std::sin(0.9) * m.up[axis_of(sensor)] : 0.0;
  });
  for (LoggedRun& run : campaign.runs) run.run.site.latitude_deg = 0.9 * 180.0 / 3.14159265358979;
  const GapReport report = find_gap(campaign, 1);
  expect_named(report, "earth_rate");
  EXPECT_NEAR(report.effects[0].magnitude.value, 2.0 * 0.0041781 * std::sin(0.9), 0.0004);
}

TEST(FindGap, LocksTheLastRunOfManyAway) {
  Plan plan;
  plan.runs = 9;
  plan.levels = 5;
  LoggedCampaign campaign = made_up::campaign(
      plan, [&](Sensor sensor, const Moment& m) { return 2.0 * unit_of(plan, sensor) * (m.supply_v - 5.0) / 0.05; });
  std::swap(campaign.runs[8].start_utc_s, campaign.runs[3].start_utc_s);
  GapReport report = find_gap(campaign, 1);
  ASSERT_TRUE(report.locked);
  EXPECT_EQ(report.locked->label, campaign.runs[3].run.label);
  ASSERT_FALSE(report.effects.empty()) << report.reason;
  const auto& gap = report.locked->gap[0];
  ASSERT_TRUE(gap && gap->closed_fraction);
  EXPECT_GT(*gap->closed_fraction, 0.6);
  EXPECT_FALSE(gap->closed_ci95);
  // Nothing else has seen it: its readings change no other figure.
  const double before = report.effects[0].delta_bic;
  for (Segment& segment : campaign.runs[3].run.segments) {
    for (Block& block : segment.blocks) block.sensor[0].mean += 1e-4 * block.t_s / 30000.0;
  }
  report = find_gap(campaign, 1);
  EXPECT_EQ(report.effects[0].delta_bic, before);
  campaign.runs.pop_back();
  EXPECT_FALSE(find_gap(campaign, 1).locked);
}

TEST(FindGap, NamesTheEvenOrderOfAnAccelerometer) {
  const Plan plan;
  expect_named(report_of(plan,
                         [&](Sensor sensor, const Moment& m) {
                           const double f = m.up[axis_of(sensor)];
                           return is_gyro(sensor) ? 0.0 : 1.5 * plan.accel_block * f * f;
                         }),
               "scale_nonlinearity");
}

TEST(FindGap, NamesMisalignmentThatMovesWithTemperature) {
  const Plan plan;
  expect_named(report_of(plan,
                         [&](Sensor sensor, const Moment& m) {
                           const double f = m.up[(axis_of(sensor) + 1) % 3];
                           return is_gyro(sensor) ? 0.0 : 3.0 * plan.accel_block * f * (m.temp_c - 25.0) / 45.0;
                         }),
               "cross_axis");
}

TEST(FindGap, NamesMountingsThatLean) {
  const Plan plan;
  base::Random random(8);
  std::array<Vector3, 6> lean{};
  for (Vector3& angles : lean) {
    for (double& angle : angles) angle = 4e-4 * random.gaussian();
  }
  expect_named(report_of(plan,
                         [&](Sensor sensor, const Moment& m) {
                           if (is_gyro(sensor)) return 0.0;
                           const Vector3& a = lean.at(static_cast<std::size_t>(m.run));
                           const std::size_t i = axis_of(sensor);
                           return 9.81 * (m.up[(i + 1) % 3] * a[(i + 2) % 3] - m.up[(i + 2) % 3] * a[(i + 1) % 3]);
                         }),
               "fixture_tilt");
}

// What ages moves on within a run too, where it must not pass for a warm-up. No sensor stands out by itself.
TEST(FindGap, NamesAgeingOfAllSensors) {
  Plan plan;
  plan.run_share = 3.0;
  const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
    return 20.0 * unit_of(plan, sensor) * (100000.0 * m.run + m.t_s) / 500000.0;
  });
  EXPECT_EQ(name_of(report.conclusion), "named") << report.reason;
  ASSERT_EQ(report.effects.size(), 1U) << report.reason;
  EXPECT_EQ(report.effects[0].effect->name, "aging_drift");
  EXPECT_GE(report.effects[0].sensors.size(), 4U);
  EXPECT_FALSE(report.residual_structure);
}

TEST(FindGap, SaysUnknownOfCreepAfterEachTurn) {
  const Plan plan;
  const GapReport report = report_of(plan, [&](Sensor sensor, const Moment& m) {
    return 2.0 * unit_of(plan, sensor) * std::exp(-m.in_placement_s / 60.0);
  });
  EXPECT_EQ(report.conclusion, Conclusion::unknown);
  EXPECT_TRUE(report.effects.empty());
  ASSERT_TRUE(report.residual_structure);
  EXPECT_EQ(report.residual_structure->axis, "time since the fixture turned");
  EXPECT_EQ(report.residual_structure->kind, StructureKind::creep_after_turn);
}

TEST(FindGap, OfOneRunCannotJudge) {
  Plan plan;
  plan.runs = 1;
  const GapReport report = report_of(plan, hysteresis(plan));
  EXPECT_EQ(report.conclusion, Conclusion::cannot_judge);
  EXPECT_FALSE(report.reason.empty());
}

TEST(FindGap, OfNoRunCannotJudge) { EXPECT_EQ(find_gap({}, 1).conclusion, Conclusion::cannot_judge); }

TEST(FindGap, SurvivesAConstantSensorAndReadingsThatAreNoNumbers) {
  const Plan plan;
  LoggedCampaign campaign = made_up::campaign(plan, made_up::nothing());
  for (LoggedRun& run : campaign.runs) {
    for (Segment& segment : run.run.segments) {
      for (Block& block : segment.blocks) {
        block.sensor[0].mean = 0.001;
        block.sensor[4].mean = std::numeric_limits<double>::quiet_NaN();
        block.sensor[5].count = 0;
      }
    }
  }
  const GapReport report = find_gap(campaign, 1);
  EXPECT_EQ(report.conclusion, Conclusion::none) << report.reason;
  EXPECT_FALSE(report.gap[4]);
  EXPECT_FALSE(report.gap[5]);
}

TEST(FindGap, SurvivesADroppedVisitAndPositionsThatWereMixedUp) {
  const Plan plan;
  LoggedCampaign campaign = made_up::campaign(plan, made_up::nothing());
  auto& segments = campaign.runs[2].run.segments;
  std::erase_if(segments, [](const Segment& segment) { return segment.key.visit == 4; });
  for (Segment& segment : campaign.runs[3].run.segments) {
    if (segment.key.visit == 2) segment.position = position_named("+Z");
  }
  const GapReport report = find_gap(campaign, 1);
  EXPECT_TRUE(report.conclusion == Conclusion::none || report.conclusion == Conclusion::unknown) << report.reason;
}

// Visits settle some tenths of a kelvin apart, which such a thermometer does not show: readings change, it does not.
TEST(FindGap, AThermometerInWholeDegreesNamesNothing) {
  for (std::uint64_t seed = 1; seed <= made_up::fewer_under_sanitizers(6); ++seed) {
    Plan plan;
    plan.seed = seed;
    const LoggedCampaign campaign = made_up::in_whole_degrees(made_up::campaign(plan, made_up::nothing()));
    const GapReport report = find_gap(campaign, 1);
    EXPECT_EQ(report.conclusion, Conclusion::none) << "seed " << seed << ": " << report.reason;
    EXPECT_TRUE(has_note(report, "coarse_thermometer", {"1 K"})) << report.reason;
  }
}

TEST(FindGap, StepsOfTheOutputAreCountedInItsLsb) {
  LoggedCampaign campaign = made_up::campaign({}, made_up::nothing());
  campaign.samples[index_of(Sensor::accel_y)] = {.count = 1000, .step = 0.004, .noise = 0.002};
  const auto found = [&] {
    const GapReport report = find_gap(campaign, 1);
    EXPECT_EQ(report.effects.size(), 1U) << report.reason;
    return report.effects.empty() ? Magnitude{} : report.effects.front().magnitude;
  };
  EXPECT_EQ(found().unit, "m/s2");
  EXPECT_DOUBLE_EQ(found().value, 0.004);
  campaign.type.accel_lsb_mps2 = 0.002;
  EXPECT_EQ(found().unit, "LSB");
  EXPECT_DOUBLE_EQ(found().value, 2.0);
}

TEST(FindGap, WithoutLogsSaysWhatCannotBeTested) {
  const Plan plan;
  LoggedCampaign campaign = made_up::campaign(plan, made_up::nothing());
  for (LoggedRun& run : campaign.runs) {
    run.log.compressor.clear();
    run.log.supply_v.clear();
    run.start_utc_s.reset();
  }
  const GapReport report = find_gap(campaign, 1);
  std::vector<std::string> names;
  for (const NotTestable& entry : report.not_testable) names.push_back(entry.name);
  for (const char* name : {"vibration_rectification", "supply_sensitivity", "aging_drift", "quantization"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
}

}  // namespace
}  // namespace soak::calib::gap
