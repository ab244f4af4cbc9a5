// SPDX-License-Identifier: Apache-2.0
#include "station/config/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "station/plan/campaign_design.h"

namespace soak::station {
namespace {

using calib::Sweep;

/// Small plans of every kind, and all that the project ships.
std::vector<Plan> plans() {
  std::vector<Plan> all;
  const auto folder = std::filesystem::path(SOAK_TEST_FOLDER).parent_path() / "procedures";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".toml") continue;
    const auto procedure = read_procedure(entry.path());
    EXPECT_TRUE(procedure) << entry.path();
    if (procedure) all.push_back(compile_plan(*procedure));
  }
  for (const PositionChange change :
       {PositionChange::same, PositionChange::reverse, PositionChange::rotate, PositionChange::rotate_and_reverse}) {
    Procedure p;
    p.runs = 5;
    p.set_points_c = {10, 40, 40, 20};
    p.positions = {"+Y", "-Y", "-X", "+X", "+Z"};
    p.position_change = change;
    p.preflight_position_s = change == PositionChange::same ? 0.0 : 20.0;
    all.push_back(compile_plan(p));
  }
  return all;
}

Procedure two_positions() {
  Procedure p;
  p.name = "two";
  p.set_points_c = {5.0, 45.0};
  p.positions = {"+X", "-X"};
  p.preflight_position_s = 0.0;
  return p;
}

std::vector<std::string> recorded_order(const Plan& plan, const PlannedRun& run, int visit) {
  std::vector<std::string> order;
  for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
    const Step& step = plan.steps[i];
    if (step.kind == StepKind::record && step.visit == visit) order.push_back(step.position);
  }
  return order;
}

TEST(Plan, TwoPositionsAtTwoTemperaturesCompileToTheseSteps) {
  const Plan plan = compile_plan(two_positions());
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < plan.steps.size(); ++i) lines.push_back(describe(plan, i));
  EXPECT_EQ(lines, (std::vector<std::string>{
                       "R01: units on",
                       "R01 visit 0, +5 °C down: turn to +X",
                       "R01 visit 0, +5 °C down: drive the chamber to the set point",
                       "R01 visit 0, +5 °C down: wait until settled, at most 7200 s",
                       "R01 visit 0, +5 °C down: record 600 s at +X",
                       "R01 visit 0, +5 °C down: turn to -X",
                       "R01 visit 0, +5 °C down: wait until settled after the turn, at most 7200 s",
                       "R01 visit 0, +5 °C down: record 600 s at -X",
                       "R01 visit 1, +45 °C up: turn to +X",
                       "R01 visit 1, +45 °C up: drive the chamber to the set point",
                       "R01 visit 1, +45 °C up: wait until settled, at most 7200 s",
                       "R01 visit 1, +45 °C up: record 600 s at +X",
                       "R01 visit 1, +45 °C up: turn to -X",
                       "R01 visit 1, +45 °C up: wait until settled after the turn, at most 7200 s",
                       "R01 visit 1, +45 °C up: record 600 s at -X",
                       "R01: warm to +25 °C, then chamber off",
                       "R01: units off",
                   }));
}

TEST(Plan, TheEstimateIsTheSumOfItsParts) {
  Procedure p = two_positions();
  p.warm_up_s = 100.0;
  p.estimate_rate_kpmin = 2.0;
  p.estimate_settle_s = 1000.0;
  // 25 → 5 → 45 → 25 °C is 80 K at 2 K/min; the run ends warm, so no unit has to be warmed up to the end.
  const double seconds = 100.0 + 80.0 / 2.0 * 60.0 + 2 * 1000.0 + 4 * 10.0 + 2 * 30.0 + 4 * 600.0;
  EXPECT_NEAR(compile_plan(p).estimate_s(), seconds, 1e-6);
  // A chamber that is asked to ramp more slowly than it could.
  p.ramp_rate_kpmin = 1.0;
  EXPECT_NEAR(compile_plan(p).estimate_s(), seconds + 40.0 * 60.0, 1e-6);
}

TEST(Plan, ARunThatEndsColdWarmsItsUnitsUp) {
  Procedure p = two_positions();
  p.set_points_c = {45.0, 5.0};
  Procedure warm = two_positions();
  EXPECT_NEAR(compile_plan(p).estimate_s() - compile_plan(warm).estimate_s(), p.estimate_settle_s, 1e-6);
}

TEST(Plan, RemainingTimeFallsByTheEstimateOfEachStep) {
  const Plan plan = compile_plan(two_positions());
  EXPECT_EQ(plan.remaining_s(0), plan.estimate_s());
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    EXPECT_NEAR(plan.remaining_s(i) - plan.remaining_s(i + 1), plan.steps[i].estimate_s, 1e-9);
  }
  EXPECT_EQ(plan.remaining_s(plan.steps.size()), 0.0);
}

TEST(Plan, RunsCoverAllStepsAndFollowEachOther) {
  for (const Plan& plan : plans()) {
    std::size_t next = 0;
    std::set<std::string> labels;
    for (std::size_t r = 0; r < plan.runs.size(); ++r) {
      EXPECT_EQ(plan.runs[r].first_step, next);
      for (std::size_t i = plan.runs[r].first_step; i <= plan.runs[r].last_step; ++i) {
        EXPECT_EQ(plan.steps[i].run, static_cast<int>(r));
      }
      next = plan.runs[r].last_step + 1;
      labels.insert(plan.runs[r].label);
    }
    EXPECT_EQ(next, plan.steps.size());
    EXPECT_EQ(labels.size(), plan.runs.size());
  }
}

/// Whether a power cycle follows the run.
bool is_cycled(const Plan& plan, std::size_t run) {
  const std::size_t first = plan.runs.front().preflight ? 1 : 0;
  return plan.procedure.cycle_at_visit && run >= first && (run - first) % 2 == 0;
}

TEST(Plan, EveryRunBeginsWithPowerOnAndEndsWarmAndOff) {
  for (const Plan& plan : plans()) {
    const bool turned = plan.procedure.turned_deg != 0.0;
    for (std::size_t r = 0; r < plan.runs.size(); ++r) {
      const PlannedRun& run = plan.runs[r];
      const bool is_last = r + 1 == plan.runs.size();
      const std::size_t last = run.last_step - (is_last && turned ? 1 : 0);
      EXPECT_EQ(plan.steps[run.first_step + (r == 0 && turned ? 1 : 0)].kind, StepKind::power_on);
      EXPECT_EQ(plan.steps[last].kind, StepKind::power_off);
      EXPECT_EQ(plan.steps[last - 1].kind, run.preflight        ? StepKind::check
                                           : is_cycled(plan, r) ? StepKind::record
                                                                : StepKind::warm_end);
      EXPECT_EQ(plan.steps[last].seconds, is_last ? 0.0 : plan.procedure.power_off_s);
    }
  }
}

TEST(Plan, APowerCycleEndsARunAndBeginsAnotherAtTheSamePlateauWithItsSweep) {
  Procedure p = two_positions();
  p.positions = {"+X"};
  p.set_points_c = {5.0, 45.0, 5.0};
  p.runs = 2;
  p.cycle_at_visit = 1;
  const Plan plan = compile_plan(p);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i <= plan.runs.at(1).last_step; ++i) lines.push_back(describe(plan, i));
  EXPECT_EQ(lines, (std::vector<std::string>{
                       "R01: units on",
                       "R01 visit 0, +5 °C down: turn to +X",
                       "R01 visit 0, +5 °C down: drive the chamber to the set point",
                       "R01 visit 0, +5 °C down: wait until settled, at most 7200 s",
                       "R01 visit 0, +5 °C down: record 600 s at +X",
                       "R01 visit 1, +45 °C up: drive the chamber to the set point",
                       "R01 visit 1, +45 °C up: wait until settled, at most 7200 s",
                       "R01 visit 1, +45 °C up: record 600 s at +X",
                       "R01: units off for 60 s",
                       "R02: units on",
                       "R02 visit 0, +45 °C up: turn to +X",
                       "R02 visit 0, +45 °C up: drive the chamber to the set point",
                       "R02 visit 0, +45 °C up: wait until settled, at most 7200 s",
                       "R02 visit 0, +45 °C up: record 600 s at +X",
                       "R02 visit 1, +5 °C down: drive the chamber to the set point",
                       "R02 visit 1, +5 °C down: wait until settled, at most 7200 s",
                       "R02 visit 1, +5 °C down: record 600 s at +X",
                       "R02: warm to +25 °C, then chamber off",
                       "R02: units off for 60 s",
                   }));
  EXPECT_EQ(plan.runs.size(), 4u);
}

TEST(Plan, PowerCyclesInARowRepeatTheVisitInRunsOfTheirOwn) {
  Procedure p = two_positions();
  p.set_points_c = {25.0, 5.0, 45.0};
  p.runs = 2;
  p.cycle_at_visit = 0;
  p.cycles = 3;
  p.preflight_position_s = 0.0;
  const Plan plan = compile_plan(p);
  std::vector<std::vector<double>> recorded_c(plan.runs.size());
  for (const Step& step : plan.steps) {
    if (step.kind == StepKind::set_temperature) recorded_c[static_cast<std::size_t>(step.run)].push_back(step.temp_c);
  }
  const std::vector<double> alone = {25.0};
  const std::vector<double> pass = {25.0, 5.0, 45.0};
  EXPECT_EQ(recorded_c, (std::vector{alone, alone, alone, pass, alone, alone, alone, pass}));
}

/// The part of `half_gap` that a plan's power-ons at one plateau see on average: 1 where all are on the heating branch.
/// From the steps alone; the loop opens in the middle of all temperatures and is closed where they turn.
double lone_share_of_gap(const Plan& plan) {
  double low_c = 25.0;
  double high_c = 25.0;
  for (const Step& step : plan.steps) {
    low_c = std::min(low_c, step.temp_c);
    high_c = std::max(high_c, step.temp_c);
  }
  double before_c = 25.0;
  double way = 0.0;
  std::vector<std::vector<double>> runs(plan.runs.size());
  for (const Step& step : plan.steps) {
    if (step.kind != StepKind::set_temperature && step.kind != StepKind::warm_end) continue;
    if (step.temp_c != before_c) way = step.temp_c > before_c ? 1.0 : -1.0;
    before_c = step.temp_c;
    const double z = (2.0 * step.temp_c - low_c - high_c) / (high_c - low_c);
    if (step.kind == StepKind::set_temperature) runs[static_cast<std::size_t>(step.run)].push_back(way * (1.0 - z * z));
  }
  double sum = 0.0;
  double count = 0.0;
  for (const auto& visits : runs) {
    if (visits.size() != 1) continue;
    sum += visits.front();
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 1.0;
}

calib::UnitType type_rated(double low_c, double high_c) {
  calib::UnitType type;
  type.name = "rated";
  type.temp_min_c = low_c;
  type.temp_max_c = high_c;
  return type;
}

TEST(Plan, PowerCyclesOfADesignAreDoneWhereTheBranchesOfTheLoopMeet) {
  const PassDesign design{.passes = 3, .plateaus = 11, .power_cycles = 9};
  for (const auto& [low_c, high_c, at_c] : {std::array{-30.0, 70.0, -30.0}, std::array{45.0, 85.0, 85.0}}) {
    const PlannedRange range{low_c, high_c, type_rated(low_c - 5.0, high_c + 5.0)};
    const auto procedure = parse_procedure(procedure_text(design, range, "p", ""), "p", {range.type});
    ASSERT_TRUE(procedure) << procedure.error().message;
    EXPECT_NEAR(lone_share_of_gap(compile_plan(*procedure)), 0.0, 1e-12);
    const auto campaign = designed_campaign(design, range);
    ASSERT_TRUE(campaign);
    int alone = 0;
    for (const calib::PlannedPowerOn& power_on : campaign->recorded.power_ons) {
      if (power_on.visits.size() > 1) continue;
      alone += power_on.count;
      EXPECT_EQ(power_on.visits.front(), (calib::PlannedVisit{at_c, Sweep::unknown}));
    }
    EXPECT_EQ(alone, 27);
  }
}

TEST(Plan, PlateausOfTheFullCampaignAreNoCloserThanThoseOfTheDesigns) {
  EXPECT_EQ(full_campaign(-30.0, 70.0).plateaus, 21);
  EXPECT_EQ(full_campaign(-40.0, 100.0).plateaus, 21);
  for (const double range_c : {6.0, 10.0, 23.0, 60.0}) {
    const int full = full_campaign(20.0, 20.0 + range_c).plateaus;
    const auto finest = std::ranges::max(designs_for(20.0, 20.0 + range_c), {}, &PassDesign::plateaus).plateaus;
    EXPECT_EQ(finest, full + 1);
    EXPECT_GE(range_c / (finest - 1), 1.5);
  }
}

TEST(Plan, ANameThatIsNoBareTextStaysItself) {
  const std::string name = "a \"b\" c:\\d\n\x7f";
  const PlannedRange range{-30.0, 70.0, type_rated(-40.0, 85.0)};
  const auto procedure = parse_procedure(procedure_text({}, range, name, name), "p", {});
  ASSERT_TRUE(procedure) << procedure.error().message;
  EXPECT_EQ(procedure->name, name);
  EXPECT_EQ(procedure->description, name);
}

TEST(Plan, AVisitThatBeginsARunIsReachedFromTheEndOfTheRunBefore) {
  const auto full = designed_campaign(full_campaign(-30.0, 70.0), {-30.0, 70.0, type_rated(-40.0, 85.0)});
  ASSERT_TRUE(full);
  ASSERT_EQ(full->recorded.power_ons.size(), 2u);
  EXPECT_EQ(full->recorded.power_ons[0].visits.front(), (calib::PlannedVisit{25.0, Sweep::unknown}));
  EXPECT_EQ(full->recorded.power_ons[1].visits.front(), (calib::PlannedVisit{25.0, Sweep::down}));
  EXPECT_EQ(full->recorded.power_ons[1].count, 19);
}

TEST(Plan, ATurnOfTheFixtureIsAskedForBeforeThePreflightAndTakenBackAtTheEnd) {
  Procedure p = two_positions();
  p.preflight_position_s = 20.0;
  p.turned_deg = 90.0;
  const Plan plan = compile_plan(p);
  EXPECT_EQ(describe(plan, 0), "P00: turn the whole fixture to +90° of its usual heading, by hand");
  EXPECT_EQ(describe(plan, plan.steps.size() - 1), "R01: turn the whole fixture back to its usual heading, by hand");
  const auto turns = std::count_if(plan.steps.begin(), plan.steps.end(),
                                   [](const Step& step) { return step.kind == StepKind::turn_fixture; });
  EXPECT_EQ(turns, 2);
  EXPECT_EQ(plan_document(plan)["steps"][0]["heading_deg"], 90.0);
}

TEST(Plan, PreflightComesFirstAndNeverDrivesTheChamber) {
  for (const Plan& plan : plans()) {
    const bool wanted = plan.procedure.preflight_position_s > 0.0;
    for (std::size_t r = 0; r < plan.runs.size(); ++r) EXPECT_EQ(plan.runs[r].preflight, wanted && r == 0);
    if (!wanted) continue;
    EXPECT_EQ(plan.runs[0].label, "P00");
    EXPECT_EQ(recorded_order(plan, plan.runs[0], -1).size(), 6u);
    for (std::size_t i = 0; i <= plan.runs[0].last_step; ++i) {
      EXPECT_EQ(plan.steps[i].visit, -1);
      EXPECT_NE(plan.steps[i].kind, StepKind::set_temperature);
      EXPECT_NE(plan.steps[i].kind, StepKind::warm_end);
    }
  }
}

TEST(Plan, NothingIsRecordedUnsettledOrWhereTheFixtureDoesNotStand) {
  for (const Plan& plan : plans()) {
    std::string stands;
    double set_point_c = 1e9;
    bool settled = false;
    for (const Step& step : plan.steps) {
      if (step.kind == StepKind::power_on) stands.clear();
      if (step.kind == StepKind::move) stands = step.position;
      if (step.kind == StepKind::set_temperature) set_point_c = step.temp_c;
      if (step.kind == StepKind::move || step.kind == StepKind::set_temperature) settled = false;
      if (step.kind == StepKind::wait_stable) settled = true;
      if (step.kind != StepKind::record) continue;
      EXPECT_EQ(step.position, stands);
      if (plan.runs[static_cast<std::size_t>(step.run)].preflight) continue;
      EXPECT_TRUE(settled);
      EXPECT_EQ(step.temp_c, set_point_c);
    }
  }
}

TEST(Plan, UnitsRampInTheFirstPositionOfTheirRun) {
  for (const Plan& plan : plans()) {
    for (const PlannedRun& run : plan.runs) {
      if (run.preflight || plan.procedure.kind != ProcedureKind::soak) continue;
      const auto order = recorded_order(plan, run, 0);
      for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
        if (plan.steps[i].kind != StepKind::set_temperature) continue;
        EXPECT_EQ(plan.steps[i].position, order.front());
        EXPECT_EQ(recorded_order(plan, run, plan.steps[i].visit), order);
      }
    }
  }
}

TEST(Plan, VisitsAreTheSetPointsAndSweepsTheSignOfTheirChange) {
  for (const Plan& plan : plans()) {
    if (plan.procedure.cycle_at_visit) continue;  // a test of its own
    for (const PlannedRun& run : plan.runs) {
      if (run.preflight) continue;
      double before_c = 25.0;
      Sweep sweep = Sweep::unknown;
      std::size_t visit = 0;
      for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
        const Step& step = plan.steps[i];
        if (step.kind != StepKind::set_temperature) continue;
        ASSERT_EQ(step.visit, static_cast<int>(visit));
        EXPECT_EQ(step.temp_c, plan.procedure.set_points_c[visit]);
        if (step.temp_c != before_c) sweep = step.temp_c > before_c ? Sweep::up : Sweep::down;
        EXPECT_EQ(step.sweep, sweep);
        before_c = step.temp_c;
        ++visit;
      }
      EXPECT_EQ(visit, plan.procedure.set_points_c.size());
    }
  }
}

TEST(Plan, AReferencePlateauIsRecordedInAllPositionsAtBothEndsOfEachRun) {
  const auto procedure = parse_procedure(
      "name = \"n\"\npurpose = \"calibration\"\nkind = \"soak\"\nruns = 2\n[temperatures]\nlist_c = [-10, 50]\n"
      "[reference]\ntemp_c = 25\n[positions]\norder = [\"+X\", \"-X\", \"+Z\"]\n",
      "p.toml");
  ASSERT_TRUE(procedure) << procedure.error().message;
  const Plan plan = compile_plan(*procedure);
  ASSERT_EQ(plan.runs.size(), 3u);  // with the pre-flight
  for (std::size_t r = 1; r < plan.runs.size(); ++r) {
    std::vector<std::pair<double, Sweep>> recorded;
    for (std::size_t i = plan.runs[r].first_step; i <= plan.runs[r].last_step; ++i) {
      const Step& step = plan.steps[i];
      if (step.kind == StepKind::record) recorded.emplace_back(step.temp_c, step.sweep);
    }
    std::vector<std::pair<double, Sweep>> expected(3, {25.0, Sweep::unknown});  // the room's own temperature
    expected.insert(expected.end(), 3, {-10.0, Sweep::down});
    expected.insert(expected.end(), 3, {50.0, Sweep::up});
    expected.insert(expected.end(), 3, {25.0, Sweep::down});
    EXPECT_EQ(recorded, expected);
    EXPECT_EQ(recorded_order(plan, plan.runs[r], 0), recorded_order(plan, plan.runs[r], 3));
  }
  // A colder room is warmed up to it.
  const Plan cold = compile_plan(*procedure, 20.0);
  const auto first = std::find_if(cold.steps.begin(), cold.steps.end(), [](const Step& s) { return s.visit == 0; });
  EXPECT_EQ(first->sweep, Sweep::up);
}

TEST(Plan, AReferencePlateauCostsItsTwoVisitsAndTheWayToThem) {
  Procedure with = two_positions();
  with.set_points_c = {25.0, 5.0, 45.0, 25.0};
  const Procedure without = two_positions();
  // Each visit settles, records twice, turns back before and once between. 5 → 45 → 25 → end at 25 °C is the way that
  // the run goes anyway.
  const double visit_s = with.estimate_settle_s + 2 * with.dwell_s + 2 * 10.0 + with.stability.after_turn_s;
  EXPECT_NEAR(compile_plan(with).estimate_s() - compile_plan(without).estimate_s(), 2 * visit_s, 1e-6);
}

TEST(Plan, TheTurningPlateauKeepsItsArrivalDirection) {
  Procedure p = two_positions();
  p.set_points_c = {-30.0, 20.0, 70.0, 70.0, 20.0};
  const Plan plan = compile_plan(p);
  std::vector<Sweep> sweeps;
  for (const Step& step : plan.steps) {
    if (step.kind == StepKind::set_temperature) sweeps.push_back(step.sweep);
  }
  EXPECT_EQ(sweeps, (std::vector<Sweep>{Sweep::down, Sweep::up, Sweep::up, Sweep::up, Sweep::down}));
}

TEST(Plan, OrdersChangeFromRunToRunAndKeepEachAxisTogether) {
  Procedure p = two_positions();
  p.runs = 6;
  p.positions = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};
  const std::vector<std::pair<PositionChange, std::size_t>> expected = {{PositionChange::same, 1},
                                                                        {PositionChange::reverse, 2},
                                                                        {PositionChange::rotate, 3},
                                                                        {PositionChange::rotate_and_reverse, 6}};
  for (const auto& [change, different] : expected) {
    p.position_change = change;
    const Plan plan = compile_plan(p);
    std::set<std::vector<std::string>> orders;
    std::vector<std::string> before;
    for (const PlannedRun& run : plan.runs) {
      const auto order = recorded_order(plan, run, 0);
      for (std::size_t i = 0; i < order.size(); i += 2) EXPECT_EQ(order[i][1], order[i + 1][1]);
      EXPECT_EQ(std::set<std::string>(order.begin(), order.end()).size(), 6u);
      if (change != PositionChange::same) {
        EXPECT_NE(order, before);
      }
      orders.insert(order);
      before = order;
    }
    EXPECT_EQ(orders.size(), different);
  }
}

TEST(Plan, LabelsTellThePurpose) {
  Procedure p = two_positions();
  p.runs = 2;
  for (const auto& [purpose, label] : {std::pair{Purpose::calibration, "R02"}, std::pair{Purpose::verification, "V02"},
                                       std::pair{Purpose::diagnosis, "D02"}}) {
    p.purpose = purpose;
    EXPECT_EQ(compile_plan(p).runs.back().label, label);
  }
}

TEST(Plan, ARampDrivesWithoutStopping) {
  Procedure p = two_positions();
  p.kind = ProcedureKind::ramp;
  p.positions = {"+Z"};
  const Plan plan = compile_plan(p);
  std::vector<StepKind> kinds;
  for (const Step& step : plan.steps) kinds.push_back(step.kind);
  EXPECT_EQ(kinds, (std::vector<StepKind>{StepKind::power_on, StepKind::move, StepKind::set_temperature,
                                          StepKind::set_temperature, StepKind::warm_end, StepKind::power_off}));
}

TEST(Plan, TheRoomDecidesTheFirstSweep) {
  const Procedure p = two_positions();
  EXPECT_EQ(compile_plan(p, 25.0).steps[2].sweep, Sweep::down);
  EXPECT_EQ(compile_plan(p, 0.0).steps[2].sweep, Sweep::up);
  EXPECT_EQ(compile_plan(p, 5.0).steps[2].sweep, Sweep::unknown);
}

TEST(Plan, TheOutlineOfARampHasItsSetPointsWithoutRecordings) {
  Procedure p = two_positions();
  p.kind = ProcedureKind::ramp;
  p.positions = {"+Z"};
  const nlohmann::json part = *plan_around(plan_document(compile_plan(p)), 0);
  ASSERT_EQ(part["plateaus"].size(), 2U);
  for (const nlohmann::json& plateau : part["plateaus"]) EXPECT_TRUE(plateau["step"].is_null());
}

TEST(Plan, TheDocumentHoldsEveryStep) {
  Procedure p = two_positions();
  p.preflight_position_s = 20.0;
  const Plan plan = compile_plan(p);
  const nlohmann::json document = plan_document(plan);
  ASSERT_EQ(document["steps"].size(), plan.steps.size());
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    const nlohmann::json& step = document["steps"][i];
    EXPECT_EQ(step["kind"], name_of(plan.steps[i].kind));
    EXPECT_EQ(step["visit"].is_null() ? -1 : step["visit"].get<int>(), plan.steps[i].visit);
    EXPECT_EQ(step["temp_c"], plan.steps[i].temp_c);
    EXPECT_EQ(step["position"], plan.steps[i].position);
  }
  EXPECT_EQ(document["runs"][1]["label"], "R01");
  EXPECT_EQ(document["runs"][1]["last_step"], plan.steps.size() - 1);
  EXPECT_EQ(document["procedure"]["purpose"], "calibration");
  EXPECT_EQ(document["estimate_s"], plan.estimate_s());
}

TEST(Plan, AroundAStepAreTheStepsOfItsPlateauAndAnOutlineOfItsRun) {
  Procedure p = two_positions();
  p.runs = 3;
  p.preflight_position_s = 20.0;
  const Plan plan = compile_plan(p);
  const nlohmann::json document = plan_document(plan);
  for (std::size_t at = 0; at < plan.steps.size(); ++at) {
    const auto part = plan_around(document, static_cast<std::int64_t>(at));
    ASSERT_TRUE(part);
    const std::size_t first = (*part)["first_step"];
    const std::size_t end = first + (*part)["steps"].size();
    ASSERT_TRUE(first <= at && at < end);
    for (std::size_t i = 0; i < plan.steps.size(); ++i) {
      const bool is_there = i >= first && i < end;
      if (is_there) {
        EXPECT_EQ((*part)["steps"][i - first], document["steps"][i]);
      }
      if (is_there) {
        EXPECT_EQ(plan.steps[i].visit, plan.steps[at].visit);
      }
    }
    EXPECT_NEAR((*part)["later_s"].get<double>(), plan.remaining_s(end), 1e-6);
    EXPECT_EQ((*part)["plateaus"].empty(), plan.runs[static_cast<std::size_t>(plan.steps[at].run)].preflight);
    for (const nlohmann::json& plateau : (*part)["plateaus"]) {
      const std::size_t record = plateau["step"];
      EXPECT_EQ(plan.steps[record].kind, StepKind::record);
      EXPECT_EQ(plan.steps[record].run, plan.steps[at].run);
      EXPECT_EQ(plan.steps[record].visit, plateau["visit"].get<int>());
      EXPECT_NEAR(plateau["left_s"].get<double>(), plan.remaining_s(record), 1e-6);
    }
    for (const char* key : {"procedure", "runs", "estimate_s"}) EXPECT_EQ((*part)[key], document[key]);
  }
  const nlohmann::json last = *plan_around(document, static_cast<std::int64_t>(plan.steps.size()) - 1);
  const std::size_t warm = last["warm_end"]["step"];
  EXPECT_EQ(plan.steps[warm].kind, StepKind::warm_end);
  EXPECT_NEAR(last["warm_end"]["after_s"].get<double>(), plan.remaining_s(warm + 1), 1e-6);
  for (const std::int64_t step : {std::int64_t{-1}, static_cast<std::int64_t>(plan.steps.size())}) {
    const auto refused = plan_around(document, step);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().where, "around");
  }
}

}  // namespace
}  // namespace soak::station
