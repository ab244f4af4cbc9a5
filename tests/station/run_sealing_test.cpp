// SPDX-License-Identifier: Apache-2.0
// Sealing beside the engine's thread: the chamber is supervised and an abort reaches it while a run of millions of rows
// is sealed. The sealing thread is held until that was seen; no clock is asked.
#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>

#include "station/lab/safe_end.h"
#include "station/lab/steps.h"
#include "tests/station/lab_bench.h"

namespace soak::station {
namespace {

using namespace lab_bench;

/// Holds whoever comes until it is opened.
class Gate {
 public:
  void pass() {
    std::unique_lock lock(mutex_);
    reached_ = true;
    changed_.notify_all();
    changed_.wait(lock, [&] { return open_; });
  }
  void wait_until_reached() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return reached_; });
  }
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool reached_ = false;
  bool open_ = false;
};

class RunSealing : public LabBench {
 protected:
  void TearDown() override {
    gate_.open();
    LabBench::TearDown();
  }

  /// Records `polls` times `rows` rows at a plateau.
  void record(int polls, std::size_t rows) {
    PlannedRun run;
    run.label = "R01";
    ASSERT_TRUE(station_->begin_run(run));
    station_->set_plateau(60.0, calib::Sweep::up, 0);
    stream_.rows_per_poll = rows;
    for (int i = 0; i < polls; ++i) ASSERT_TRUE(station_->poll());
    stream_.rows_per_poll = 1;
  }

  /// A reader of the run's file, as another program has it: the file cannot be sealed meanwhile.
  std::optional<db::RunFileReader> read_elsewhere() {
    EXPECT_TRUE(station_->flush());
    return db::RunFileReader::open(folder_ / "runs" / (station_->run_id() + ".soakrun")).value();
  }

  std::unique_ptr<StepTask> power_off() const {
    Step step;
    step.kind = StepKind::power_off;
    return make_task(station_->campaign.plan, step);
  }

  Gate gate_;
};

TEST_F(RunSealing, AnAbortReachesTheChamberWhileALongRunIsSealed) {
  constexpr std::size_t kRows = 500'000;
  record(20, kRows / 20);
  station_->sealer.before_work = [&] { gate_.pass(); };
  const auto task = power_off();
  ASSERT_EQ(task->poll(*station_).state, StepState::running);
  gate_.wait_until_reached();
  const int reads_before = chamber_.reads;
  int turns = 0;
  turns_until([&] {
    EXPECT_EQ(task->poll(*station_).state, StepState::running) << "the run is not in the catalog yet";
    return chamber_.reads >= reads_before + 5 && ++turns >= 50;
  });
  EXPECT_TRUE(catalog_->runs({})->empty());
  // The abort: the chamber is driven, and off, while the file is still held.
  SafeEnd safe_end("aborted", 25.0, false, true);
  bool over = false;
  turns_until([&] {
    over = safe_end.poll(*station_);
    return over || !chamber_.running;
  });
  EXPECT_FALSE(over);
  EXPECT_EQ(chamber_.set_point_c, 25.0);
  EXPECT_FALSE(chamber_.running);
  gate_.open();
  turns_until([&] { return safe_end.poll(*station_); });
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 1U);
  EXPECT_EQ(runs->front().rows, kRows);
  EXPECT_TRUE(runs->front().sealed);
  EXPECT_FALSE(runs->front().voided) << "it was complete before the abort";
  EXPECT_TRUE(catalog_->check_run_file(runs->front()));
}

TEST_F(RunSealing, AFailureIsTriedAgainUntilTheRunIsEntered) {
  record(2, 1000);
  auto reader = read_elsewhere();
  const auto task = power_off();
  int reads_before = 0;
  turns_until([&] {
    EXPECT_EQ(task->poll(*station_).state, StepState::running);
    reads_before = chamber_.reads;
    return !station_->seal_trouble().empty();
  });
  EXPECT_TRUE(catalog_->runs({})->empty());
  reader.reset();
  StepProgress progress;
  turns_until([&] {
    progress = task->poll(*station_);
    return progress.state != StepState::running;
  });
  EXPECT_EQ(progress.state, StepState::done) << progress.text;
  EXPECT_EQ(station_->seal_trouble(), "");
  EXPECT_GT(chamber_.reads, reads_before) << "the chamber is supervised meanwhile";
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 1U);
  EXPECT_EQ(runs->front().rows, 2000U);
  EXPECT_FALSE(runs->front().voided);
}

TEST_F(RunSealing, ADataFolderThatIsGoneIsWaitedForAndNotMadeAnew) {
  record(2, 1000);
  station_->campaign.plan.procedure.give_up_h = 12.0;
  ASSERT_TRUE(station_->flush());
  const fs::path away = folder_.string() + ".away";
  fs::rename(folder_, away);
  const auto task = power_off();
  turns_until([&] {
    EXPECT_EQ(task->poll(*station_).state, StepState::running);
    return !station_->seal_trouble().empty();
  });
  EXPECT_FALSE(fs::exists(folder_));
  fs::rename(away, folder_);
  StepProgress progress;
  turns_until([&] {
    progress = task->poll(*station_);
    return progress.state != StepState::running;
  });
  EXPECT_EQ(progress.state, StepState::done) << progress.text;
  EXPECT_EQ(catalog_->runs({})->size(), 1U);
}

TEST_F(RunSealing, AFailureThatLastsForTooLongComesBackAndTheSafeEndTriesAgain) {
  record(2, 1000);
  station_->campaign.plan.procedure.give_up_h = 0.0;
  auto reader = read_elsewhere();
  const auto task = power_off();
  StepProgress progress;
  turns_until([&] {
    progress = task->poll(*station_);
    return progress.state != StepState::running;
  });
  EXPECT_EQ(progress.state, StepState::failed) << "somebody else has the file open";
  EXPECT_TRUE(catalog_->runs({})->empty());
  reader.reset();
  SafeEnd safe_end("the disk was full", 25.0, true, false);
  turns_until([&] { return safe_end.poll(*station_); });
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 1U);
  EXPECT_EQ(runs->front().rows, 2000U);
  EXPECT_FALSE(runs->front().voided) << "it was complete before it could not be sealed";
}

TEST_F(RunSealing, AFailureHoldsAChamberAtItsPlateauForMinutesNotForTheTimeOfASuspension) {
  record(2, 1000);
  station_->campaign.plan.procedure.give_up_h = 12.0;
  station_->chamber.expect(60.0);
  auto reader = read_elsewhere();
  const auto task = power_off();
  turns_until([&] {
    EXPECT_EQ(task->poll(*station_).state, StepState::running);
    return !station_->seal_trouble().empty();
  });
  const double begun_s = station_->now_s();
  stream_.rows_per_poll = 1000;  // ten seconds of the unit's clock
  StepProgress progress;
  turns_until([&] {
    progress = task->poll(*station_);
    return progress.state != StepState::running;
  });
  EXPECT_EQ(progress.state, StepState::failed);
  EXPECT_GT(station_->now_s() - begun_s, 500.0);
  EXPECT_LT(station_->now_s() - begun_s, 12.0 * 3600.0);
}

TEST_F(RunSealing, WhatIsLeftBehindIsEnteredBesideTheLoop) {
  record(2, 1000);
  const std::string run_id = station_->run_id();
  ASSERT_TRUE(station_->flush());
  station_->leave_run();
  station_->sealer.before_work = [&] { gate_.pass(); };
  ASSERT_FALSE(station_->enter_left_runs().value());
  gate_.wait_until_reached();
  int turns = 0;
  turns_until([&] {
    EXPECT_FALSE(station_->enter_left_runs().value());
    return ++turns >= 50;
  });
  gate_.open();
  turns_until([&] { return station_->enter_left_runs().value(); });
  ASSERT_EQ(catalog_->runs({})->size(), 1U);
  EXPECT_EQ(catalog_->runs({})->front().run_id, run_id);
}

TEST_F(RunSealing, WhileTheOperatorIsAskedOnlyTheLastSamplesBeforeTheRunAreKept) {
  constexpr std::size_t kRows = 200'000;
  station_->expect_run();
  station_->prompts.ask({"Switch the units off and on.", "power"});
  stream_.rows_per_poll = kRows / 50;
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(station_->poll());
  station_->prompts.withdraw();
  record(1, 1000);
  turns_until([&] { return station_->end_run(std::nullopt).value(); });
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 1U);
  EXPECT_LE(runs->front().rows, 50'000U);
  EXPECT_GE(runs->front().rows, 20'000U) << "a minute and a half at 200 Hz";
}

TEST_F(RunSealing, WhileNobodyIsAskedAllSamplesBeforeTheRunAreKept) {
  station_->expect_run();
  stream_.rows_per_poll = 2'000;
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(station_->poll());
  record(1, 1000);
  turns_until([&] { return station_->end_run(std::nullopt).value(); });
  ASSERT_EQ(catalog_->runs({})->size(), 1U);
  EXPECT_EQ(catalog_->runs({})->front().rows, 101'000U);
}

}  // namespace
}  // namespace soak::station
