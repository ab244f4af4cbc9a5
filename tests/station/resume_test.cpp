// SPDX-License-Identifier: Apache-2.0
// A campaign that was cut short at any step of any plan: what is carried out from there on is held against what the
// undisturbed plan does.
#include "station/lab/resume.h"

#include "tests/long_tests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

namespace soak::station {
namespace {

constexpr double kRoomC = 25.0;

/// All procedures that the project ships, of three runs at most (later ones repeat them), and small ones of kinds that
/// it does not.
std::vector<Plan> all_plans() {
  std::vector<Plan> plans;
  const auto folder = std::filesystem::path(SOAK_TEST_FOLDER).parent_path() / "procedures";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".toml") continue;
    auto procedure = read_procedure(entry.path());
    EXPECT_TRUE(procedure) << entry.path();
    if (!procedure) continue;
    procedure->runs = std::min(procedure->runs, 3);
    plans.push_back(compile_plan(*procedure, kRoomC));
  }
  for (const std::vector<double>& set_points_c : std::vector<std::vector<double>>{
           {10, 40, 40, 20}, {40}, {40, 0}, {-20, 0, 20, 40, 60, 40, 20, 0, -20}, {60, -40, 60, 10}}) {
    for (const int cycles : {0, 1, 3}) {
      Procedure p;
      p.runs = 2;
      p.set_points_c = set_points_c;
      p.positions = {"+Y", "-Y", "+X"};
      if (set_points_c.size() > 1 && cycles > 0) {
        p.cycle_at_visit = 0;
        p.cycles = cycles;
      }
      p.preflight_position_s = cycles > 0 ? 20.0 : 0.0;
      plans.push_back(compile_plan(p, kRoomC));
    }
  }
  return plans;
}

/// What a campaign measures: where each recording was made, and how the temperature came there.
struct Recorded {
  std::size_t step = 0;
  double temp_c = 0.0;       ///< of the chamber
  double came_from_c = 0.0;  ///< the last temperature before this one at which it turned; the room's where it did not
  std::string position;      ///< of the fixture; empty = nobody knows
  bool has_power = false;
  bool operator==(const Recorded&) const = default;
};

/// Carries out steps one by one from a room-warm chamber, with units off and the fixture anywhere.
class StoppedLab {
 public:
  explicit StoppedLab(const Plan& plan) : plan_(plan) {}

  void carry_out(std::size_t index) {
    const Step& step = plan_.steps[index];
    switch (step.kind) {
      case StepKind::power_on:
        has_power_ = true;
        break;
      case StepKind::power_off:
        has_power_ = false;
        break;
      case StepKind::move:
        position_ = step.position;
        break;
      case StepKind::set_temperature:
        drive_to(step.temp_c);
        break;
      case StepKind::warm_end:
        temps_c_ = {kRoomC};
        break;
      case StepKind::record:
        recorded.push_back({index, temps_c_.back(), came_from_c(), position_, has_power_});
        break;
      default:
        break;
    }
  }

  void drive_to(double temp_c) {
    if (temp_c != temps_c_.back()) temps_c_.push_back(temp_c);
  }

  std::vector<Recorded> recorded;

 private:
  /// The temperature behind which the way to the present one goes in one direction.
  [[nodiscard]] double came_from_c() const {
    std::size_t k = temps_c_.size() - 1;
    if (k == 0) return kRoomC;
    const bool rises = temps_c_[k] > temps_c_[k - 1];
    while (k > 0 && (temps_c_[k] > temps_c_[k - 1]) == rises) --k;
    return temps_c_[k];
  }

  const Plan& plan_;
  std::vector<double> temps_c_ = {kRoomC};
  std::string position_;
  bool has_power_ = false;
};

std::map<std::size_t, Recorded> undisturbed(const Plan& plan) {
  StoppedLab lab(plan);
  for (std::size_t i = 0; i < plan.steps.size(); ++i) lab.carry_out(i);
  std::map<std::size_t, Recorded> by_step;
  for (const Recorded& recorded : lab.recorded) by_step[recorded.step] = recorded;
  return by_step;
}

std::set<std::size_t> first_steps(std::size_t count) {
  std::set<std::size_t> steps;
  for (std::size_t i = 0; i < count; ++i) steps.insert(steps.end(), i);
  return steps;
}

/// What is measured after a break, to the end of the run that follows the present one.
std::vector<Recorded> after_break(const Plan& plan, const WayBack& way) {
  StoppedLab lab(plan);
  for (const std::size_t step : way.steps) lab.carry_out(step);
  const auto run = static_cast<std::size_t>(plan.steps[way.steps.back()].run);
  const std::size_t end = plan.runs[std::min(run + 1, plan.runs.size() - 1)].last_step;
  for (std::size_t i = way.steps.back() + 1; i <= end; ++i) lab.carry_out(i);
  return lab.recorded;
}

TEST(WayBack, EveryRecordingAfterABreakIsMadeAsItWouldHaveBeenWithoutIt) {
  SOAK_LONG_TEST();
  for (const Plan& plan : all_plans()) {
    const auto truth = undisturbed(plan);
    const std::size_t end = plan.runs[std::min<std::size_t>(2, plan.runs.size() - 1)].last_step;
    for (std::size_t cut = 1; cut <= end; ++cut) {
      const WayBack way = way_back(plan, first_steps(cut), kRoomC);
      ASSERT_FALSE(way.steps.empty());
      for (const Recorded& recorded : after_break(plan, way)) {
        const Recorded& wanted = truth.at(recorded.step);
        ASSERT_EQ(recorded.temp_c, wanted.temp_c)
            << describe(plan, recorded.step) << ", cut before " << describe(plan, cut);
        ASSERT_EQ(recorded.came_from_c, wanted.came_from_c)
            << describe(plan, recorded.step) << ", cut before " << describe(plan, cut);
        ASSERT_EQ(recorded.position, wanted.position)
            << describe(plan, recorded.step) << ", cut before " << describe(plan, cut);
        ASSERT_TRUE(recorded.has_power) << describe(plan, recorded.step);
      }
    }
  }
}

TEST(WayBack, RepeatsTheVisitBeforeTheBreakAndNothingBeforeThat) {
  for (const Plan& plan : all_plans()) {
    const PlannedRun& run = plan.runs.back();
    for (std::size_t cut = run.first_step + 1; cut <= run.last_step; ++cut) {
      const auto repeated = after_break(plan, way_back(plan, first_steps(cut), kRoomC));
      std::set<std::size_t> after;
      for (const Recorded& recorded : repeated) EXPECT_TRUE(after.insert(recorded.step).second) << "recorded twice";
      const int cut_visit = plan.steps[cut].visit;
      for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
        if (plan.steps[i].kind != StepKind::record) continue;
        if (i >= cut) {
          ASSERT_TRUE(after.contains(i)) << "left out: " << describe(plan, i);
        }
        if (cut_visit < 0) continue;  // behind the last visit, judged below
        if (plan.steps[i].visit < cut_visit - 1) {
          EXPECT_FALSE(after.contains(i)) << describe(plan, i) << " again, cut before " << describe(plan, cut);
        }
        if (plan.steps[i].visit == cut_visit - 1) {
          EXPECT_TRUE(after.contains(i)) << describe(plan, i) << " not again, cut before " << describe(plan, cut);
        }
      }
    }
  }
}

/// Of a plateau that is given up (on_timeout = "skip") the journal has no step behind the waiting.
TEST(WayBack, DoesNotGoBackToAPlateauThatWasSkipped) {
  SOAK_LONG_TEST();
  for (const Plan& plan : all_plans()) {
    const PlannedRun& run = plan.runs.back();
    std::set<std::size_t> skipped;
    for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
      if (plan.steps[i].visit == 0 && plan.steps[i].kind == StepKind::record) skipped.insert(i);
    }
    for (std::size_t cut = run.first_step + 1; cut <= run.last_step; ++cut) {
      if (plan.steps[cut].visit == 0 || plan.steps[cut - 1].visit == 0) continue;
      const std::set<std::size_t> all = first_steps(cut);
      std::set<std::size_t> ended = all;
      for (const std::size_t step : skipped) ended.erase(step);
      ASSERT_EQ(way_back(plan, ended, kRoomC).steps, way_back(plan, all, kRoomC).steps)
          << "cut before " << describe(plan, cut);
    }
  }
}

/// The first step of a run behind its last visit.
std::size_t behind_visits(const Plan& plan, const PlannedRun& run) {
  std::size_t behind = run.last_step;
  while (plan.steps[behind - 1].visit < 0 && plan.steps[behind - 1].kind != StepKind::record) --behind;
  return behind;
}

TEST(WayBack, MeasuresNothingAgainWhereAllVisitsAreDone) {
  for (const Plan& plan : all_plans()) {
    const PlannedRun& run = plan.runs.back();
    for (std::size_t cut = behind_visits(plan, run); cut <= run.last_step; ++cut) {
      EXPECT_TRUE(after_break(plan, way_back(plan, first_steps(cut), kRoomC)).empty()) << describe(plan, cut);
    }
  }
}

TEST(WayBack, SaysFirstWhatFollowsARunThatHasAllItsVisits) {
  bool one_begins = false;
  for (const Plan& plan : all_plans()) {
    for (const PlannedRun& run : plan.runs) {
      const std::string said = way_back(plan, first_steps(behind_visits(plan, run)), kRoomC).text;
      EXPECT_FALSE(said.ends_with("; ") || said.starts_with(run.label + " has all its visits;")) << said;
      one_begins = one_begins || said.ends_with(" begins (" + run.label + " has all its visits)");
    }
  }
  EXPECT_TRUE(one_begins);
}

TEST(WayBack, ARunIsRepeatedFromItsFirstVisitWhereTheProcedureSaysSo) {
  SOAK_LONG_TEST();
  for (Plan plan : all_plans()) {
    plan.procedure.on_break = BreakOutcome::repeat_run;
    const auto truth = undisturbed(plan);
    const PlannedRun& run = plan.runs.back();
    for (std::size_t cut = run.first_step + 1; cut <= run.last_step; ++cut) {
      if (plan.steps[cut].kind == StepKind::turn_fixture) continue;
      const auto repeated = after_break(plan, way_back(plan, first_steps(cut), kRoomC));
      const auto all =
          std::count_if(truth.begin(), truth.end(), [&](const auto& step) { return step.first >= run.first_step; });
      EXPECT_EQ(repeated.size(), static_cast<std::size_t>(all));
      for (const Recorded& recorded : repeated)
        ASSERT_EQ(recorded, truth.at(recorded.step)) << describe(plan, recorded.step);
    }
  }
}

/// The steps of a plan at which the units are on and a plateau is under way or reached.
std::vector<std::size_t> steps_of_visits(const Plan& plan) {
  std::vector<std::size_t> steps;
  const std::size_t end = plan.runs[std::min<std::size_t>(2, plan.runs.size() - 1)].last_step;
  for (std::size_t i = 0; i <= end; ++i) {
    if (plan.steps[i].visit >= 0) steps.push_back(i);
  }
  return steps;
}

/// The first step of the visit that a step belongs to.
std::size_t begin_of_visit(const Plan& plan, std::size_t step) {
  const Step& here = plan.steps[step];
  while (step > 0 && plan.steps[step - 1].run == here.run && plan.steps[step - 1].visit == here.visit) --step;
  return step;
}

TEST(WayToVisit, MeasuresTheRestOfARunAsItWouldHaveBeenThoughTheChamberHasGoneToTheRoomMeanwhile) {
  for (const Plan& plan : all_plans()) {
    const auto truth = undisturbed(plan);
    for (const std::size_t cut : steps_of_visits(plan)) {
      StoppedLab lab(plan);
      for (std::size_t i = 0; i < cut; ++i) lab.carry_out(i);
      lab.recorded.clear();
      lab.drive_to(kRoomC);
      const auto way = way_to_visit(plan, cut, {kRoomC, kRoomC, true});
      ASSERT_EQ(way.back(), begin_of_visit(plan, cut));
      for (const std::size_t step : way) {
        ASSERT_GE(plan.steps[step].visit, 0) << "the units keep their power: " << describe(plan, step);
        lab.carry_out(step);
      }
      const auto run = static_cast<std::size_t>(plan.steps[cut].run);
      for (std::size_t i = way.back() + 1; i <= plan.runs[run].last_step; ++i) lab.carry_out(i);
      for (const Recorded& recorded : lab.recorded) {
        ASSERT_EQ(recorded, truth.at(recorded.step))
            << describe(plan, recorded.step) << ", suspended at " << describe(plan, cut);
      }
    }
  }
}

TEST(WayToVisit, IsTheVisitAloneWhereTheAirHasStayedAtThePlateau) {
  for (const Plan& plan : all_plans()) {
    for (const std::size_t cut : steps_of_visits(plan)) {
      const double there_c = plan.steps[cut].temp_c;
      for (const double air_c : {there_c - 2.9, there_c, there_c + 2.9}) {
        ASSERT_EQ(way_to_visit(plan, cut, {air_c, kRoomC, false}), std::vector{begin_of_visit(plan, cut)});
      }
    }
  }
}

TEST(WayToVisit, LeadsStraightOnFromHalfWayToThePlateauButNotFromBeyondTheOneBefore) {
  Procedure p;
  p.set_points_c = {10, 30, 50, 70};
  p.positions = {"+Y", "-Y"};
  p.preflight_position_s = 0.0;
  const Plan plan = compile_plan(p, kRoomC);
  for (const std::size_t cut : steps_of_visits(plan)) {
    if (plan.steps[cut].visit != 2 || plan.steps[cut].kind != StepKind::set_temperature) continue;
    EXPECT_EQ(way_to_visit(plan, cut, {40.0, kRoomC, false}).size(), 1U);
    const auto way = way_to_visit(plan, cut, {20.0, kRoomC, false});
    ASSERT_GT(way.size(), 1U);
    const auto first =
        std::ranges::find_if(way, [&](std::size_t step) { return plan.steps[step].kind == StepKind::set_temperature; });
    EXPECT_EQ(plan.steps[*first].temp_c, 10.0) << "where the temperature turned last";
  }
}

// soakd was killed after the last step, before the campaign had been written down as finished.
TEST(WayBack, IsTheLastStepAgainWhereAllHaveEnded) {
  for (const Plan& plan : all_plans()) {
    const std::size_t last = plan.steps.size() - 1;
    EXPECT_EQ(way_back(plan, first_steps(plan.steps.size()), kRoomC).steps, std::vector<std::size_t>{last});
    EXPECT_TRUE(plan.steps[last].kind == StepKind::power_off || plan.steps[last].kind == StepKind::turn_fixture);
  }
}

TEST(WayToVisit, GoesBackFromWhereverTheAirHasLeftAPlateauThatItHadReached) {
  Procedure p;
  p.set_points_c = {10, 30, 50, 70};
  p.positions = {"+Y", "-Y"};
  p.rate_positions = {"+Y"};
  p.rates_dps = {30.0};
  p.preflight_position_s = 0.0;
  const Plan plan = compile_plan(p, kRoomC);
  for (const std::size_t cut : steps_of_visits(plan)) {
    const std::size_t begin = begin_of_visit(plan, cut);
    const auto drive = std::find_if(plan.steps.begin() + static_cast<std::ptrdiff_t>(begin), plan.steps.end(),
                                    [](const Step& step) { return step.kind == StepKind::set_temperature; });
    if (plan.steps[cut].visit != 2 || cut <= static_cast<std::size_t>(drive - plan.steps.begin())) continue;
    // On the way from 30 to 50 degrees it could be there; at the plateau of 50 it has gone back.
    EXPECT_GT(way_to_visit(plan, cut, {40.0, kRoomC, false}).size(), 1U) << describe(plan, cut);
  }
}

}  // namespace
}  // namespace soak::station
