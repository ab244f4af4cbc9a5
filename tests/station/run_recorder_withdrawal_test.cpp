// SPDX-License-Identifier: Apache-2.0
// Visits and attempts as the plan numbers them, and segments that are withdrawn.
#include <gtest/gtest.h>

#include <algorithm>

#include "station/fit/fit_unit.h"
#include "station/lab/run_recorder.h"
#include "tests/station/run_recorder_bench.h"

namespace soak::station {
namespace {

using namespace recorder_bench;

/// Position, visit and attempt of segments, in the order of time.
std::vector<std::string> names_of(const std::vector<calib::Segment>& segments) {
  std::vector<std::string> names;
  for (const calib::Segment& segment : segments) {
    names.push_back(std::to_string(segment.key.visit) + segment.key.position + std::to_string(segment.key.attempt));
  }
  return names;
}

TEST_F(RunRecorderTest, NumbersVisitsAndAttemptsAsThePlanDoes) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  ASSERT_EQ(runs->size(), 2U);
  for (const db::RunRow& run : *runs) {
    const auto segments = catalog_->segments(run.run_id, run.unit, true);
    EXPECT_EQ(names_of(*segments), (std::vector<std::string>{"0+X0", "0-X0", "1+X0", "1+X1", "1-X0", "2-X0", "2+X0"}));
    EXPECT_EQ((*segments)[1].plateau_c, 65.0);
    EXPECT_EQ((*segments)[1].sweep, Sweep::up);
    EXPECT_EQ((*segments)[3].plateau_c, 70.0);
    EXPECT_EQ((*segments)[5].plateau_c, 65.0);
    EXPECT_EQ((*segments)[5].sweep, Sweep::down);
    for (const auto& segment : *segments) {
      EXPECT_EQ(segment.sensor[0].count, 100U);
      EXPECT_NEAR(segment.t_end_s - segment.t_start_s, 9.9, 1e-9);
    }
  }
}

TEST_F(RunRecorderTest, WithdrawsRejectedSegmentsOfTheirUnitOnly) {
  RunRecorder recorder = begin(info());
  recorder.reject(1, "nothing recorded yet");
  record_up_and_down(recorder, {{{0, 2}, "temperature moved 0.2 K"}, {{0, 5}, "unit was silent"}});
  EXPECT_EQ(recorder.rejected(), 3U);
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  const std::string& run_id = runs->front().run_id;
  EXPECT_EQ(names_of(*catalog_->segments(run_id, "SN1", false)),
            (std::vector<std::string>{"0+X0", "0-X0", "1+X1", "1-X0", "2+X0"}));
  EXPECT_EQ(catalog_->segments(run_id, "SN2", false)->size(), 7U);
  const auto voids = catalog_->voids(run_id);
  ASSERT_EQ(voids->size(), 2U);
  EXPECT_EQ(voids->front().reason, "temperature moved 0.2 K");
  EXPECT_EQ(voids->front().user, "soakd");
  const auto events = catalog_->events();
  const auto logged =
      std::find_if(events->begin(), events->end(), [](const auto& e) { return e.kind == "nothing_to_void"; });
  ASSERT_NE(logged, events->end());
}

TEST_F(RunRecorderTest, WithdrawsThePartOfOneUnitOnly) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto entered = recorder.finish({}, {{"SN1", "the unit restarted"}, {"SN9", "is not in this run"}});
  ASSERT_TRUE(entered) << entered.error().message;
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 2U);
  for (const db::RunRow& run : *runs) EXPECT_EQ(run.voided, run.unit == "SN1") << run.unit;
  const std::string& run_id = runs->front().run_id;
  EXPECT_TRUE(catalog_->segments(run_id, "SN1", false)->empty());
  EXPECT_EQ(catalog_->segments(run_id, "SN2", false)->size(), 7U);
  const auto voids = catalog_->voids(run_id);
  ASSERT_EQ(voids->size(), 1U);
  EXPECT_EQ(voids->front().unit, "SN1");
  EXPECT_FALSE(voids->front().visit);
  EXPECT_EQ(voids->front().reason, "the unit restarted");
  EXPECT_EQ(voids->front().user, "soakd");
  std::vector<calib::Warning> warnings;
  EXPECT_TRUE(load_unit(*catalog_, "SN2", {}, warnings));
  EXPECT_FALSE(load_unit(*catalog_, "SN1", {}, warnings)) << "nothing is left to fit";
}

TEST_F(RunRecorderTest, AUnitThatWasLostBeforeTheRunEndedKeepsItsOwnReason) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto entered = recorder.finish("the campaign was aborted", {{"SN1", "the unit restarted"}});
  ASSERT_TRUE(entered) << entered.error().message;
  const auto voids = catalog_->voids(entered->front().run_id);
  ASSERT_EQ(voids->size(), 2U);
  for (const db::VoidRecord& record : *voids) {
    EXPECT_EQ(record.reason, record.unit == "SN1" ? "the unit restarted" : "the campaign was aborted");
  }
  const auto runs = catalog_->runs({});
  for (const db::RunRow& run : *runs) EXPECT_TRUE(run.voided) << run.unit;
}

TEST_F(RunRecorderTest, APartThatIsKeptHasItsReasonAndIsFitted) {
  RunRecorder recorder = begin(info());
  record_up_and_down(recorder);
  const auto entered = recorder.finish("the chamber died", {{"SN1", "the unit restarted"}}, true);
  ASSERT_TRUE(entered) << entered.error().message;
  EXPECT_TRUE(catalog_->voids(entered->front().run_id)->empty());
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 2U);
  for (const db::RunRow& run : *runs) {
    EXPECT_EQ(run.cut_short, run.unit == "SN1" ? "the unit restarted" : "the chamber died");
    EXPECT_FALSE(run.voided) << run.unit;
    EXPECT_EQ(catalog_->segments(run.run_id, run.unit, false)->size(), 7U) << run.unit;
  }
}

/// Starts of segments, s.
std::vector<double> starts_of(const std::vector<calib::Segment>& segments) {
  std::vector<double> starts;
  for (const calib::Segment& segment : segments) starts.push_back(segment.t_start_s);
  return starts;
}

TEST_F(RunRecorderTest, OneRampRowInTheSamePositionSeparatesTwoAttempts) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
  Unit unit(6);
  // As the lab labels its rows: set point, visit and position stay while it waits for the units to settle.
  RowLabels waiting{Phase::ramp, Sweep::up, 30.0, "+Y", 4};
  RowLabels recording = waiting;
  recording.phase = Phase::soak;
  ASSERT_TRUE(recorder.add(0, unit.samples(40, 30.0F), waiting));  // from 0.1 s
  for (int attempt = 0; attempt < 3; ++attempt) {
    ASSERT_TRUE(recorder.add(0, unit.samples(1, 30.0F), waiting));
    // Two calls that follow each other are one attempt.
    ASSERT_TRUE(recorder.add(0, unit.samples(60, 30.0F), recording));
    ASSERT_TRUE(recorder.add(0, unit.samples(39, 30.0F), recording));
    if (attempt == 1) recorder.reject(0, "the temperature moved");
  }
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  const std::string& run_id = runs->front().run_id;
  const auto left = catalog_->segments(run_id, "SN1", false);
  EXPECT_EQ(names_of(*left), (std::vector<std::string>{"4+Y0", "4+Y2"}));
  const auto starts = starts_of(*left);
  ASSERT_EQ(starts.size(), 2U);
  EXPECT_NEAR(starts[0], 4.2, 1e-9);
  EXPECT_NEAR(starts[1], 24.2, 1e-9);
  for (const calib::Segment& segment : *left) EXPECT_EQ(segment.sensor[0].count, 99U);
  EXPECT_EQ(catalog_->voids(run_id)->size(), 1U);
}

TEST_F(RunRecorderTest, WithdrawsAttemptsOfARunWithoutPlateaus) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
  Unit unit(7);
  const RowLabels standing{Phase::soak, Sweep::unknown, {}, "+X", -1};
  RowLabels turned = standing;
  turned.position = "-X";
  ASSERT_TRUE(recorder.add(0, unit.samples(400, 22.0F), standing));
  ASSERT_TRUE(recorder.add(0, unit.samples(1, 22.0F), ramp(Sweep::unknown)));
  recorder.reject(0, "samples were missing");
  ASSERT_TRUE(recorder.add(0, unit.samples(400, 22.0F), turned));
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  const auto left = catalog_->segments(runs->front().run_id, "SN1", false);
  ASSERT_FALSE(left->empty());
  for (const calib::Segment& segment : *left) EXPECT_EQ(segment.key.position, "-X");
}

TEST_F(RunRecorderTest, KeepsThePlansVisitsWhereAPlateauWasSkipped) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
  Unit unit(3);
  RowLabels labels = soak(10.0, "+X");
  labels.visit = 0;
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), labels));
  labels = ramp(Sweep::up);
  labels.visit = 1;  // 20 °C, which gave up
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 20.0F), labels));
  labels = soak(10.0, "+X", Sweep::down);
  labels.visit = 2;
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), labels));
  recorder.reject(0, "wrong");
  labels.position = "";
  ASSERT_TRUE(recorder.add(0, unit.samples(1, 10.0F), labels));
  labels = soak(10.0, "+X", Sweep::down);
  labels.visit = 3;  // the same set point twice in a row: no excursion tells the two apart
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), labels));
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  EXPECT_EQ(names_of(*catalog_->segments(runs->front().run_id, "SN1", false)),
            (std::vector<std::string>{"0+X0", "3+X0"}));
}

TEST_F(RunRecorderTest, WithdrawsAllPartsOfASegmentThatAGapHasCut) {
  RunRecorder recorder = begin(info(), {{"SN1", "mti"}});
  Unit unit(4);
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), soak(10.0, "+X")));
  static_cast<void>(unit.samples(150, 10.0F));  // 15 s that were lost
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), soak(10.0, "+X")));
  recorder.reject(0, "15 s are missing");
  ASSERT_TRUE(recorder.add(0, unit.samples(1, 10.0F), soak(10.0, "")));
  ASSERT_TRUE(recorder.add(0, unit.samples(100, 10.0F), soak(10.0, "+X")));
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  EXPECT_EQ(catalog_->voids(runs->front().run_id)->size(), 2U);
  const auto left = catalog_->segments(runs->front().run_id, "SN1", false);
  ASSERT_EQ(left->size(), 1U);
  EXPECT_NEAR(left->front().t_start_s, 35.2, 1e-9);
}

TEST_F(RunRecorderTest, WithdrawsWhatWasCompleteAtAVisitThatBeginsAgainAndNothingOfTheOthers) {
  RunRecorder recorder = begin(info());
  Unit unit(1);
  const auto record = [&](int visit, const std::string& position) {
    RowLabels labels;
    labels.plateau_c = 60.0 + 5.0 * visit;
    labels.sweep = Sweep::up;
    labels.visit = visit;
    labels.phase = Phase::soak;
    labels.position = position;
    ASSERT_TRUE(recorder.add(0, unit.samples(100, 60.0F), labels));
    recorder.accept(0);
    labels.phase = Phase::ramp;
    labels.position = "";
    ASSERT_TRUE(recorder.add(0, unit.samples(20, 60.0F), labels));
  };
  record(0, "+X");
  record(1, "+X");
  record(1, "-X");
  EXPECT_EQ(recorder.withdraw_visit(1, 1, "begins again"), 0U) << "the other unit has nothing there";
  EXPECT_EQ(recorder.withdraw_visit(0, 1, "begins again"), 2U);
  EXPECT_EQ(recorder.withdraw_visit(0, 1, "begins again"), 0U) << "once is enough";
  record(1, "+X");
  record(1, "-X");
  const auto runs = recorder.finish();
  ASSERT_TRUE(runs) << runs.error().message;
  EXPECT_EQ(names_of(*catalog_->segments(runs->front().run_id, "SN1", false)),
            (std::vector<std::string>{"0+X0", "1+X1", "1-X1"}));
}

}  // namespace
}  // namespace soak::station
