// SPDX-License-Identifier: Apache-2.0
// Runs that a killed process left behind.
#include <gtest/gtest.h>

#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <filesystem>

#include "db/catalog/catalog.h"
#include "station/lab/campaign_log.h"
#include "station/lab/run_recorder.h"
#include "tests/station/run_recorder_bench.h"

namespace soak::station {
namespace {

using namespace recorder_bench;
using LostRuns = RunRecorderTest;

/// What the log says of runs.
std::vector<std::string> told_of_runs(const db::Catalog& catalog) {
  std::vector<std::string> texts;
  const auto events = catalog.events();
  for (const db::EventRow& event : *events) {
    if (event.kind == "run") texts.push_back(event.text);
  }
  return texts;
}

/// Does something in a process of its own, which is then killed.
template <class F>
void do_and_die(F&& something) {
  const pid_t child = ::fork();
  if (child == 0) {
    something();
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
}

/// Records as soakd does and is killed: `rows` rows of SN1 are flushed, some more are not.
void record_and_die(const fs::path& data_folder, const db::RunInfo& info, std::size_t rows) {
  do_and_die([&] {
    auto catalog = db::Catalog::open(data_folder);
    auto recorder = RunRecorder::begin(*catalog, info, "verification", {{"SN1", "mti"}, {"SN2", "mti"}});
    Unit unit(1);
    // Nothing of this is checked here: a failure shows as rows that are missing.
    static_cast<void>(recorder->add(0, unit.samples(rows, 20.0F), soak(20.0, "+X")));
    static_cast<void>(recorder->flush());
    static_cast<void>(recorder->add(0, unit.samples(50, 20.0F), soak(20.0, "+X")));
  });
}

TEST_F(LostRuns, WithoutACompleteSegmentAreEnteredVoidedWithEveryRowThatWasFlushed) {
  db::RunInfo lost = info();
  lost.source = kRunSource;
  record_and_die(folder_, lost, 20'000);
  ASSERT_FALSE(db::orphan_run_files(*catalog_)->empty());
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 1U) << "SN2 gave no row";
  const db::RunRow& run = runs->front();
  EXPECT_EQ(run.run_id, lost.run_id);
  EXPECT_EQ(run.rows, 20'000U);
  EXPECT_EQ(run.purpose, "verification");
  EXPECT_TRUE(run.sealed);
  EXPECT_TRUE(run.voided);
  EXPECT_EQ((*catalog_->unit("SN1"))->type, "mti") << "known since the run began";
  const auto file = db::RunFileReader::open(catalog_->run_file_path(run));
  EXPECT_TRUE(file->sealed());
  EXPECT_TRUE(file->verify());
  EXPECT_EQ(file->events()->back().kind, "interrupted");
  EXPECT_TRUE(db::orphan_run_files(*catalog_)->empty());
  ASSERT_EQ(told_of_runs(*catalog_).size(), 1U);
}

/// The segments of a run that nothing has withdrawn, as "visit position attempt".
std::vector<std::string> usable_segments(const db::Catalog& catalog, const db::RunRow& run) {
  std::vector<std::string> usable;
  const auto segments = catalog.segments(run.run_id, run.unit, false);
  for (const calib::Segment& segment : *segments) {
    usable.push_back(std::to_string(segment.key.visit) + " " + segment.key.position + " " +
                     std::to_string(segment.key.attempt));
  }
  return usable;
}

TEST_F(LostRuns, KeepWhatWasCompleteAndWithdrawWhatWasRejectedOrUnderWay) {
  db::RunInfo lost = info();
  lost.source = kRunSource;
  do_and_die([&] {
    auto catalog = db::Catalog::open(folder_);
    auto recorder = RunRecorder::begin(*catalog, lost, "calibration", {{"SN1", "mti"}, {"SN2", "mti"}});
    Unit first(1);
    Unit second(2);
    const auto record = [&](const RowLabels& labels) {
      static_cast<void>(recorder->add(0, first.samples(200, 20.0F), labels));
      static_cast<void>(recorder->add(1, second.samples(200, 20.0F), labels));
    };
    const auto pause = [&] { record(soak(20.0, "")); };
    pause();
    record(soak(20.0, "+X"));
    recorder->accept(0);
    recorder->reject(1, "the unit moved");
    pause();
    record(soak(20.0, "+X"));
    recorder->accept(1);
    pause();
    record(soak(20.0, "-X"));
    recorder->accept(0);
    recorder->accept(1);
    pause();
    record(soak(20.0, "+Y"));
    static_cast<void>(recorder->flush());
  });
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 2U);
  std::map<std::string, std::vector<std::string>> usable;
  for (const db::RunRow& run : *runs) {
    EXPECT_FALSE(run.voided) << run.unit;
    EXPECT_FALSE(run.cut_short.empty()) << run.unit;
    usable[run.unit] = usable_segments(*catalog_, run);
  }
  using Segments = std::vector<std::string>;
  // SN1 recorded +X once more without being asked to: what it gave there was never judged.
  EXPECT_EQ(usable["SN2"], (Segments{"0 +X 1", "0 -X 0"}));
  EXPECT_TRUE(std::ranges::find(usable["SN1"], "0 +X 0") != usable["SN1"].end());
  EXPECT_TRUE(std::ranges::find(usable["SN1"], "0 -X 0") != usable["SN1"].end());
  EXPECT_TRUE(std::ranges::find(usable["SN1"], "0 +Y 0") == usable["SN1"].end());
}

/// A run with one complete segment.
void record_a_segment_and_die(const fs::path& data_folder, const db::RunInfo& info, const std::string& purpose) {
  do_and_die([&] {
    auto catalog = db::Catalog::open(data_folder);
    auto recorder = RunRecorder::begin(*catalog, info, purpose, {{"SN1", "mti"}});
    Unit unit(1);
    static_cast<void>(recorder->add(0, unit.samples(200, 20.0F), soak(20.0, "+X")));
    recorder->accept(0);
    static_cast<void>(recorder->add(0, unit.samples(200, 20.0F), soak(20.0, "")));
    static_cast<void>(recorder->flush());
  });
}

TEST_F(LostRuns, KeepTheEpochInWhichTheyBeganThoughTheUnitWasRepairedSince) {
  ASSERT_TRUE(catalog_->ensure_unit("SN1", "mti"));
  ASSERT_TRUE(catalog_->begin_epoch("SN1", "re-flashed", "ann"));
  db::RunInfo lost = info();
  lost.source = kRunSource;
  record_a_segment_and_die(folder_, lost, "calibration");
  ASSERT_TRUE(catalog_->begin_epoch("SN1", "gyro replaced", "ann"));
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 1U);
  EXPECT_EQ(runs->front().epoch, 1);
  EXPECT_EQ((*catalog_->unit("SN1"))->epoch, 2);
}

TEST_F(LostRuns, OfAPreFlightAreVoided) {
  db::RunInfo lost = info("P00");
  lost.source = kRunSource;
  record_a_segment_and_die(folder_, lost, "diagnosis");
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 1U);
  EXPECT_TRUE(runs->front().voided);
  EXPECT_TRUE(runs->front().cut_short.empty());
}

TEST_F(LostRuns, OfAnAbortedCampaignAreVoidedThoughTheyHoldCompleteSegments) {
  for (const std::string campaign : {"c", "d"}) {
    db::RunInfo lost = info("R-" + campaign);
    lost.source = kRunSource;
    lost.campaign = campaign;
    record_a_segment_and_die(folder_, lost, "calibration");
  }
  ASSERT_TRUE(enter_lost_runs(*catalog_, std::string("c")));
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 2U);
  for (const db::RunRow& run : *runs) EXPECT_EQ(run.voided, run.label == "R-c") << run.label;
}

/// A row of the catalog as text, but for what the file itself does not hold.
std::string text_of(const db::Catalog& catalog, const db::RunRow& run) {
  std::string text = run.label + " " + run.unit + " " + run.purpose + " " + std::to_string(run.rows) + " " +
                     run.file_sha256 + (run.voided ? " void" : "") + " cut short: " + run.cut_short +
                     ", type: " + (*catalog.unit(run.unit))->type;
  for (const std::string& segment : usable_segments(catalog, run)) text += ", " + segment;
  const auto voids = catalog.voids(run.run_id);
  for (const db::VoidRecord& record : *voids) {
    if (record.unit == run.unit) text += ", void " + record.position.value_or("all") + ": " + record.reason;
  }
  return text;
}

std::vector<std::string> all_runs(const db::Catalog& catalog) {
  std::vector<std::string> texts;
  const auto runs = catalog.runs({});
  for (const db::RunRow& run : *runs) texts.push_back(text_of(catalog, run));
  std::ranges::sort(texts);
  return texts;
}

/// Runs that ended in every way there is, newer than the catalog that is restored under them.
class RunsNewerThanTheCatalog : public LostRuns {
 protected:
  void SetUp() override {
    LostRuns::SetUp();
    ASSERT_TRUE(catalog_->copy_to(folder_ / "backup.db"));
  }

  void record(const std::string& label, const std::string& purpose, const RunEnd& end) {
    db::RunInfo about = info(label);
    about.source = kRunSource;
    auto recorder = RunRecorder::begin(*catalog_, about, purpose, {{"SN1", "mti-300"}, {"SN2", "mti-30"}});
    ASSERT_TRUE(recorder);
    record_up_and_down(*recorder, {{{1, 2}, "the unit moved"}});
    ASSERT_TRUE(recorder->finish(*catalog_, end));
  }

  void restore_catalog() {
    catalog_.reset();
    for (const char* name : {"station.db", "station.db-wal", "station.db-shm"}) fs::remove(folder_ / name);
    fs::rename(folder_ / "backup.db", folder_ / "station.db");
    auto catalog = db::Catalog::open(folder_);
    ASSERT_TRUE(catalog);
    catalog_ = std::make_unique<db::Catalog>(*std::move(catalog));
    ASSERT_TRUE(catalog_->runs({})->empty());
  }
};

TEST_F(RunsNewerThanTheCatalog, AreEnteredAsTheyEnded) {
  record("P00", "diagnosis", {});
  record("R01", "calibration", {});
  record("R02", "calibration", {.void_units = {{"SN2", "the unit was lost"}}, .keeps_parts = true});
  record("R03", "calibration", {.void_reason = "aborted by ann", .keeps_parts = true});
  record("R04", "verification", {.void_reason = "aborted by ann"});
  const auto before = all_runs(*catalog_);
  ASSERT_EQ(before.size(), 10U);
  restore_catalog();
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  EXPECT_EQ(all_runs(*catalog_), before);
  EXPECT_TRUE(db::orphan_run_files(*catalog_)->empty());
}

/// Files of earlier versions do not.
TEST_F(RunsNewerThanTheCatalog, AreCutShortWhereTheirFileDoesNotSayHowTheyEnded) {
  record("R01", "calibration", {});
  const auto file = catalog_->run_file_path(catalog_->runs({})->front());
  restore_catalog();
  sqlite3* database = nullptr;
  ASSERT_EQ(::sqlite3_open(file.c_str(), &database), SQLITE_OK);
  ASSERT_EQ(::sqlite3_exec(database, "DELETE FROM event WHERE kind = 'ended'", nullptr, nullptr, nullptr), SQLITE_OK);
  ::sqlite3_close(database);
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 2U);
  for (const db::RunRow& run : *runs) {
    EXPECT_FALSE(run.voided) << run.unit;
    EXPECT_FALSE(run.cut_short.empty()) << run.unit;
  }
}

TEST_F(LostRuns, WithoutSamplesAreToldOfOnce) {
  db::RunInfo lost = info();
  lost.source = kRunSource;
  record_and_die(folder_, lost, 0);
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  EXPECT_TRUE(catalog_->runs({})->empty());
  EXPECT_TRUE(db::orphan_run_files(*catalog_)->front().sealed);
  EXPECT_EQ(told_of_runs(*catalog_).size(), 1U);
}

TEST_F(LostRuns, LeavesTheFilesOfOthersAlone) {
  record_and_die(folder_, info(), 100);  // says that it is no file of soakd's
  EventLog log(*catalog_);
  ASSERT_TRUE(enter_lost_runs(*catalog_, log));
  EXPECT_FALSE(db::orphan_run_files(*catalog_)->front().sealed);
  EXPECT_TRUE(told_of_runs(*catalog_).empty());
}

}  // namespace
}  // namespace soak::station
