// SPDX-License-Identifier: Apache-2.0
#include "station/runs/run_archive.h"

#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/errors.h"
#include "tests/station/stored_runs.h"

namespace soak::station {
namespace {

using nlohmann::json;
using testing::kStoredRunId;

/// Run r1 with a file and four segments, of which a record withdraws one and the gate rejects another.
class Archive : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(catalog_.ensure_unit("SN1", "generic"));
    ASSERT_TRUE(catalog_.ensure_campaign("c1", "soak"));
    const db::RunRow run = testing::stored_run(catalog_, testing::StoredNumbers());
    auto segments = db::testing::segments_of(run);
    segments[2].findings = {{"moved", calib::Severity::reject, std::nullopt, "it was moved"}};
    segments[3].findings = {{"spike", calib::Severity::warn, std::nullopt, "a spike"}};
    ASSERT_TRUE(catalog_.add_run(run, segments));
    ASSERT_TRUE(catalog_.add_void({kStoredRunId, "SN1", 0, "-X", 0, "fixture slipped", "ann", 1700000100.0}));
  }

  void add_run_without_file(const std::string& run_id, const std::string& label, double created_utc_s,
                            bool sealed = true) {
    db::RunRow run = db::testing::run_row(run_id, label);
    run.created_utc_s = created_utc_s;
    run.sealed = sealed;
    ASSERT_TRUE(catalog_.add_run(run, {}));
  }

  json show() {
    const auto shown = archive_.show({kStoredRunId, "SN1"});
    EXPECT_TRUE(shown) << shown.error().message;
    return shown.value_or(json());
  }

  db::testing::TempFolder folder_;
  db::Catalog catalog_ = db::Catalog::open(folder_.path()).value();
  RunArchive archive_{folder_.path()};
};

TEST_F(Archive, ListsTheNewestRunFirstWithWhatBecameOfItsSegments) {
  add_run_without_file("01990a5d-ac96-774b-bcce-b302099a8057", "r2", 1800000000.0);
  const json list = archive_.list({}).value();
  EXPECT_EQ(list["not_listed"], 0);
  ASSERT_EQ(list["runs"].size(), 2);
  EXPECT_EQ(list["runs"][0]["run"], "r2");
  EXPECT_EQ(list["runs"][0]["segments"], json({{"recorded", 0}, {"withdrawn", 0}, {"rejected", 0}}));
  EXPECT_EQ(list["runs"][1]["run"], "r1");
  EXPECT_EQ(list["runs"][1]["segments"], json({{"recorded", 4}, {"withdrawn", 1}, {"rejected", 1}}));
  EXPECT_EQ(list["runs"][1]["void"], nullptr);
}

TEST_F(Archive, ListsRunsOfOneUnitOrCampaign) {
  EXPECT_EQ(archive_.list({.unit = "SN1"}).value()["runs"].size(), 1);
  EXPECT_EQ(archive_.list({.unit = "SN2"}).value()["runs"].size(), 0);
  EXPECT_EQ(archive_.list({.campaign = "c1"}).value()["runs"].size(), 1);
  EXPECT_EQ(archive_.list({.campaign = "%"}).value()["runs"].size(), 0);
}

TEST_F(Archive, AListIsBoundedAndSaysHowManyItLeavesOut) {
  const auto added = catalog_.all_or_nothing([&]() -> base::Status {
    for (int i = 0; i < 1005; ++i) {
      const std::string number = std::to_string(100000 + i);
      db::RunRow run = db::testing::run_row("01990a5d-ac96-774b-bcce-b30209" + number, "n" + number);
      run.created_utc_s = 1.8e9 + i;
      if (auto done = catalog_.add_run(run, {}); !done) return done;
    }
    return {};
  });
  ASSERT_TRUE(added);
  const json list = archive_.list({}).value();
  EXPECT_EQ(list["runs"].size(), RunArchive::kMostRuns);
  EXPECT_EQ(list["not_listed"], 6);
  EXPECT_EQ(list["runs"][0]["run"], "n101004");
}

TEST_F(Archive, ShowsWithdrawnSegmentsWithTheReasonAndFindingsOfTheGate) {
  const json shown = show();
  ASSERT_EQ(shown["segments"].size(), 4);
  EXPECT_EQ(shown["segments"][0]["void"], nullptr);
  EXPECT_EQ(shown["segments"][1]["void"]["reason"], "fixture slipped");
  EXPECT_EQ(shown["segments"][1]["void"]["user"], "ann");
  EXPECT_EQ(shown["segments"][2]["findings"][0]["severity"], "reject");
  EXPECT_EQ(shown["segments"][2]["attempt"], 1);
  EXPECT_EQ(shown["voids"].size(), 1);
  EXPECT_EQ(shown["run"]["run_id"], kStoredRunId);
}

TEST_F(Archive, AVoidIsARecordAndAnEventOfItsUser) {
  const json made =
      archive_.withdraw({kStoredRunId, "SN1", std::nullopt, std::nullopt, std::nullopt, "door open", "eva", 0.0})
          .value();
  EXPECT_EQ(made["segments_withdrawn"], 3);
  EXPECT_EQ(made["segments_before"], 3);
  const auto records = catalog_.voids(kStoredRunId).value();
  ASSERT_EQ(records.size(), 2);
  EXPECT_EQ(records[1].reason, "door open");
  EXPECT_EQ(records[1].user, "eva");
  EXPECT_GT(records[1].utc_s, 1.7e9);
  const auto events = catalog_.events().value();
  EXPECT_EQ(events.back().kind, "voided");
  EXPECT_EQ(events.back().subject, kStoredRunId);
  EXPECT_EQ(events.back().user, "eva");
  EXPECT_TRUE(catalog_.segments(kStoredRunId, "SN1", false).value().empty());
  EXPECT_EQ(archive_.list({}).value()["runs"][0]["void"]["reason"], "door open");
  const json shown = show();
  for (const json& segment : shown["segments"]) EXPECT_FALSE(segment["void"].is_null());
}

TEST_F(Archive, WhatIsVoidAlreadyOrNotThereIsNotVoidedAndLeavesNoRecord) {
  const auto events = catalog_.events().value().size();
  EXPECT_TRUE(
      base::is_bad_input(archive_.withdraw({kStoredRunId, "SN1", 0, "-X", 0, "again", "eva", 0.0}), {"0/+X/0"}));
  EXPECT_TRUE(base::is_bad_input(archive_.withdraw({kStoredRunId, "SN1", 9, {}, {}, "x", "eva", 0.0})));
  EXPECT_TRUE(base::is_bad_input(archive_.withdraw({kStoredRunId, "SN2", {}, {}, {}, "x", "eva", 0.0})));
  EXPECT_EQ(catalog_.events().value().size(), events);
  ASSERT_TRUE(archive_.withdraw({kStoredRunId, "SN1", {}, {}, {}, "x", "eva", 0.0}));
  EXPECT_TRUE(base::is_bad_input(archive_.withdraw({kStoredRunId, "SN1", {}, {}, {}, "y", "eva", 0.0})));
}

TEST_F(Archive, ARunThatIsStillWrittenIsNotOpened) {
  const std::string id = "01990a5d-ac96-774b-bcce-b302099a8057";
  add_run_without_file(id, "r2", 1.8e9, false);
  for (const auto& answer : {archive_.show({id, "SN1"}), archive_.series({{id, "SN1"}, "imu", {"gyro_x"}})}) {
    ASSERT_TRUE(base::is_bad_input(answer));
    EXPECT_EQ(answer.error().where, "run");
  }
}

TEST_F(Archive, ARunWhoseFileIsGoneOrDamagedIsToldOf) {
  const std::string id = "01990a5d-ac96-774b-bcce-b302099a8057";
  add_run_without_file(id, "r2", 1.8e9);
  EXPECT_FALSE(archive_.show({id, "SN1"}));
  EXPECT_TRUE(archive_.show({kStoredRunId, "SN1"}));
}

TEST_F(Archive, ManyQuestionsAtOnceAreAnsweredOrRefusedAsBusy) {
  std::atomic<int> answered = 0;
  std::atomic<int> busy = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 40; ++i) {
    threads.emplace_back([&] {
      const auto answer =
          archive_.series({{kStoredRunId, "SN1"}, "imu", {"gyro_x", "accel_x", "temp_c"}, {}, {}, 2000});
      if (answer)
        ++answered;
      else if (answer.error().where == kBusy)
        ++busy;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(answered + busy, 40);
  EXPECT_GE(answered, 1);
}

TEST(ArchiveOfNoFolder, RefusesEverything) {
  RunArchive archive{{}};
  EXPECT_TRUE(base::is_bad_input(archive.list({})));
}

TEST_F(Archive, WhatIsWorkedOutOfUnitsHoldsUntilAnEventIsEnteredOrADayBegins) {
  WorkedOut worked_out;
  int times = 0;
  const auto again = [&] { return base::Result<json>(++times); };
  const auto look = [&](std::string_view day) {
    EXPECT_TRUE(worked_out.renew(catalog_, day));
    const json all = *worked_out.of_all(again);
    return std::pair(all, *worked_out.of("SN1", nullptr, again));
  };
  EXPECT_EQ(look("2026-11-28"), std::pair(json(1), json(2)));
  EXPECT_EQ(look("2026-11-28"), std::pair(json(1), json(2)));
  ASSERT_TRUE(catalog_.add_void({kStoredRunId, "SN1", 1, "", 0, "moved", "ann", 1700000200.0}));
  EXPECT_EQ(look("2026-11-28"), std::pair(json(3), json(4)));
  EXPECT_EQ(look("2026-11-29"), std::pair(json(5), json(6)));
  EXPECT_EQ(*worked_out.of("SN2", nullptr, [] { return base::Result<json>("another unit"); }), "another unit");
}

TEST(WorkedOutOfUnits, DoesNotHoldForACatalogWithAsManyOtherEvents) {
  WorkedOut worked_out;
  int times = 0;
  db::EventFilter newest;
  newest.most = 1;
  std::int64_t events = 0;
  for (const char* text : {"before the backup", "after it was restored"}) {
    const db::testing::TempFolder folder;
    db::Catalog catalog = db::Catalog::open(folder.path()).value();
    ASSERT_TRUE(catalog.log_event({.utc_s = 1700000200.0, .kind = "note", .subject = "SN1", .text = text}));
    events = catalog.find_events(newest).value().at(0).number;
    ASSERT_TRUE(worked_out.renew(catalog, "2026-11-28"));
    EXPECT_EQ(*worked_out.of_all([&] { return base::Result<json>(++times); }), times);
  }
  EXPECT_EQ(events, 1);
  EXPECT_EQ(times, 2);
}

TEST_F(Archive, WhatIsWorkedOutOfAUnitIsAskedAgainWithAnotherVerificationAndAfterAnError) {
  WorkedOut worked_out;
  ASSERT_TRUE(worked_out.renew(catalog_, "2026-11-28"));
  const auto says = [&](const json& job, base::Result<json> found) {
    return worked_out.of("SN1", job, [&] { return found; });
  };
  EXPECT_FALSE(says({{"id", 1}}, base::bad_input("damaged", "model")));
  EXPECT_EQ(*says({{"id", 1}}, json("failed")), "failed");
  EXPECT_EQ(*says({{"id", 1}}, json("not asked")), "failed");
  EXPECT_EQ(*says({{"id", 2}}, json("passed")), "passed");
}

TEST_F(Archive, WhatNeverChangesIsWorkedOutOnceThoughSeveralAskAtATime) {
  constexpr int kThreads = 4;
  std::atomic<int> asking = 0;
  std::atomic<int> worked = 0;
  const auto ask = [&] {
    ++asking;
    const auto answer = archive_.once("noise of r1", [&]() -> base::Result<json> {
      while (asking < kThreads) std::this_thread::yield();
      return archive_.compute([&]() -> base::Result<json> { return json(++worked); });
    });
    ASSERT_TRUE(answer);
    EXPECT_EQ(*answer, 1);
  };
  std::vector<std::jthread> threads;
  for (int i = 0; i < kThreads; ++i) threads.emplace_back(ask);
  threads.clear();
  ask();
  EXPECT_EQ(worked, 1);
}

TEST_F(Archive, OthersHaveTheirTurnWhileOneThingIsWorkedOut) {
  const auto answer = archive_.once("noise of r1", [&]() -> base::Result<json> {
    EXPECT_TRUE(archive_.list({}));
    EXPECT_TRUE(archive_.compute([]() -> base::Result<json> { return json(1); }));
    return json(2);
  });
  EXPECT_EQ(answer.value(), 2);
}

TEST_F(Archive, KeepsTheNewestAnswersAndNoError) {
  int worked = 0;
  const auto ask = [&](const std::string& key) {
    return archive_.once(key, [&]() -> base::Result<json> { return json(++worked); });
  };
  EXPECT_FALSE(archive_.once("first", []() -> base::Result<json> { return base::bad_input("not now"); }));
  EXPECT_EQ(ask("first").value(), 1);
  for (std::size_t i = 1; i < KeptAnswers::kMostKept; ++i) EXPECT_TRUE(ask(std::to_string(i)));
  EXPECT_EQ(ask("first").value(), 1);
  EXPECT_TRUE(ask("one more"));
  EXPECT_EQ(ask("first").value(), worked) << "it was the oldest";
}

}  // namespace
}  // namespace soak::station
