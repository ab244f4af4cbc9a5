// SPDX-License-Identifier: Apache-2.0
// Sealing beside the engine's thread: the chamber is supervised and an abort reaches it while a run of millions of rows
// is sealed. The sealing thread is held until that was seen; no clock is asked.
#include <gtest/gtest.h>

#include <unistd.h>
#include <array>
#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "db/catalog/catalog.h"
#include "station/lab/safe_end.h"
#include "station/lab/station.h"
#include "station/lab/steps.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

/// Obeys at once, and counts.
class ObedientChamber : public hal::Chamber {
 public:
  base::Status connect() override { return {}; }
  base::Result<hal::ChamberReading> read() override {
    ++reads;
    hal::ChamberReading reading;
    reading.air_c = reading.set_point_c = set_point_c;
    reading.running = running;
    return reading;
  }
  base::Status set_temperature(double temp_c) override {
    ++commands;
    set_point_c = temp_c;
    return {};
  }
  base::Status set_ramp_rate(std::optional<double>) override { return {}; }
  base::Status start() override {
    running = true;
    return {};
  }
  base::Status stop() override {
    running = false;
    return {};
  }
  std::optional<double> min_set_point_c() const override { return std::nullopt; }
  std::optional<double> max_set_point_c() const override { return std::nullopt; }
  bool can_ramp() const override { return false; }
  std::string description() const override { return "obedient"; }

  double set_point_c = 60.0;
  bool running = true;
  int reads = 0;
  int commands = 0;
};

/// Streams `rows_per_poll` rows of 100 Hz with each poll.
class RushingImu : public hal::Imu {
 public:
  explicit RushingImu(const std::size_t& rows_per_poll) : rows_per_poll_(rows_per_poll) {}
  base::Status open(const Settings&) override { return {}; }
  void close() override {}
  base::Status poll(std::vector<hal::ImuSample>& samples) override {
    for (std::size_t i = 0; i < rows_per_poll_; ++i) {
      hal::ImuSample sample;
      sample.packet = ++row_;
      sample.t_s = 0.01 * static_cast<double>(row_);
      sample.rate_rps = {1e-3F * static_cast<float>(row_ % 7), 0.0F, 0.0F};
      sample.accel_mps2 = {9.8F + 1e-3F * static_cast<float>(row_ % 5), 0.0F, 0.0F};
      sample.temp_c = 60.0F;
      samples.push_back(sample);
    }
    return {};
  }
  hal::ImuState state() const override { return hal::ImuState::streaming; }
  const std::optional<hal::ImuIdentity>& identity() const override { return identity_; }
  const hal::ImuStatistics& statistics() const override { return statistics_; }
  int wait_fd() const override { return -1; }
  std::string description() const override { return "rushing"; }

 private:
  const std::size_t& rows_per_poll_;
  std::uint32_t row_ = 0;
  std::optional<hal::ImuIdentity> identity_ = hal::ImuIdentity{"SN1", "", "", true};
  hal::ImuStatistics statistics_;
};

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

class RunSealing : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-sealing-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    auto catalog = db::Catalog::open(folder_);
    ASSERT_TRUE(catalog);
    catalog_ = std::make_unique<db::Catalog>(*std::move(catalog));
    config_.dew_point_c = 10.0;
    config_.chamber.link.poll_s = 1e-3;
    log_ = std::make_unique<EventLog>(*catalog_);
    station_ = std::make_unique<Station>(config_, *catalog_, *log_, chamber_, nullptr, nullptr);
    station_->campaign.name = "c1";
    station_->campaign.plan.procedure.name = "soak";
    auto imu = std::make_unique<RushingImu>(rows_per_poll_);
    station_->units.push_back(
        std::make_unique<UnitChannel>(Slot{}, "SN1", calib::UnitType{}, std::move(imu), hal::Imu::Settings{}));
    station_->units.front()->begin_run();
  }
  void TearDown() override {
    gate_.open();
    station_.reset();
    fs::remove_all(folder_);
  }

  /// Records `polls` times `rows` rows at a plateau.
  void record(int polls, std::size_t rows) {
    PlannedRun run;
    run.label = "R01";
    ASSERT_TRUE(station_->begin_run(run));
    station_->set_plateau(60.0, calib::Sweep::up, 0);
    rows_per_poll_ = rows;
    for (int i = 0; i < polls; ++i) ASSERT_TRUE(station_->poll());
    rows_per_poll_ = 1;
  }

  std::unique_ptr<StepTask> power_off() const {
    Step step;
    step.kind = StepKind::power_off;
    return make_task(station_->campaign.plan, step);
  }

  /// Turns of a loop as the engine's until `work` says true.
  template <class Work>
  int turns_until(Work work) {
    int turns = 0;
    for (; !work(); ++turns) {
      EXPECT_TRUE(station_->poll());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return turns;
  }

  fs::path folder_;
  std::unique_ptr<db::Catalog> catalog_;
  StationConfig config_;
  ObedientChamber chamber_;
  std::size_t rows_per_poll_ = 0;
  std::unique_ptr<EventLog> log_;
  std::unique_ptr<Station> station_;
  Gate gate_;
};

TEST_F(RunSealing, AnAbortReachesTheChamberWhileMillionsOfRowsAreSealed) {
  constexpr std::size_t kRows = 2'000'000;
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

TEST_F(RunSealing, AFailureComesBackAndTheSafeEndTriesAgain) {
  record(2, 1000);
  ASSERT_TRUE(station_->flush());
  const auto path = folder_ / "runs" / (station_->run_id() + ".soakrun");
  std::optional<db::RunFileReader> reader = db::RunFileReader::open(path).value();
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
  EXPECT_TRUE(runs->front().voided) << "it has no segment";
}

TEST_F(RunSealing, WhatIsLeftBehindIsEnteredBesideTheLoop) {
  record(2, 1000);
  const std::string run_id = station_->run_id();
  ASSERT_TRUE(station_->flush());
  station_->leave_run();
  station_->sealer.before_work = [&] { gate_.pass(); };
  ASSERT_EQ(station_->enter_left_runs(), base::Result<bool>(false));
  gate_.wait_until_reached();
  int turns = 0;
  turns_until([&] {
    EXPECT_EQ(station_->enter_left_runs(), base::Result<bool>(false));
    return ++turns >= 50;
  });
  gate_.open();
  turns_until([&] { return station_->enter_left_runs().value(); });
  ASSERT_EQ(catalog_->runs({})->size(), 1U);
  EXPECT_EQ(catalog_->runs({})->front().run_id, run_id);
}

}  // namespace
}  // namespace soak::station
