// SPDX-License-Identifier: Apache-2.0
#include "station/records/sample_drop.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "calib/model/document_parts.h"
#include "tests/errors.h"
#include "tests/station/stored_runs.h"

namespace soak::station {
namespace {

using testing::kStoredRunId;

/// A campaign with a journal and one run of two units.
class SampleDropTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* unit : {"SN1", "SN2"}) ASSERT_TRUE(catalog_.ensure_unit(unit, "generic"));
    db::CampaignRow campaign;
    campaign.name = "c1";
    campaign.procedure = "soak";
    campaign.document = "{}";
    campaign.created_utc_s = 1700000000.0;
    ASSERT_TRUE(catalog_.begin_campaign(campaign));
    run_ = testing::stored_run(catalog_, testing::StoredNumbers());
    ASSERT_TRUE(catalog_.add_run(run_, db::testing::segments_of(run_)));
    db::RunRow second = run_;
    second.unit = "SN2";
    ASSERT_TRUE(catalog_.add_run(second, db::testing::segments_of(second)));
  }

  void set_state(const char* state) { ASSERT_TRUE(catalog_.set_campaign_state("c1", state, "as the test has it")); }

  /// A stored model of the unit with one accepted term.
  void add_model_with_term(const std::string& unit) {
    calib::ModelTerm term;
    term.name = "sensor_lag";
    const nlohmann::json document = {
        {"format", "soak-model"}, {"format_version", 1}, {"terms", calib::terms_json({term})}};
    ASSERT_TRUE(catalog_.add_model(unit, 0, 1700000000.0, [&](std::int32_t) { return document.dump(); }));
  }

  [[nodiscard]] bool file_is_there() const { return std::filesystem::exists(catalog_.run_file_path(run_)); }

  db::testing::TempFolder folder_;
  db::Catalog catalog_ = db::Catalog::open(folder_.path()).value();
  db::RunRow run_;
};

TEST_F(SampleDropTest, DropsTheFileOfAllUnitsAfterTheCampaignIsOver) {
  set_state("finished");
  const auto plan = plan_sample_drop(catalog_, kStoredRunId);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->units, (std::vector<std::string>{"SN1", "SN2"}));
  EXPECT_EQ(plan->bytes, std::filesystem::file_size(catalog_.run_file_path(run_)));
  ASSERT_TRUE(drop_samples(catalog_, *plan, "room", "ann"));
  EXPECT_FALSE(file_is_there());
  const auto parts = catalog_.runs({}).value();
  ASSERT_EQ(parts.size(), 2U);
  for (const db::RunRow& part : parts) {
    ASSERT_TRUE(part.samples_dropped);
    EXPECT_EQ(part.samples_dropped->bytes, plan->bytes);
    EXPECT_TRUE(catalog_.check_run_file(part));
    EXPECT_EQ(catalog_.segments(part.run_id, part.unit, true).value().size(), 4U);
    EXPECT_EQ(catalog_.open_run_file(part).error().kind, base::ErrorKind::bad_input);
  }
  EXPECT_TRUE(catalog_.verify());
}

TEST_F(SampleDropTest, SamplesOfACampaignThatMayGoOnStay) {
  for (const char* state : {"running", "paused", "interrupted", "failed"}) {
    set_state(state);
    const auto plan = plan_sample_drop(catalog_, kStoredRunId);
    ASSERT_FALSE(plan) << state;
    EXPECT_EQ(plan.error().kind, base::ErrorKind::bad_input);
    EXPECT_TRUE(base::mentions(plan.error().message, {"c1", state}));
  }
  set_state("aborted");
  EXPECT_TRUE(plan_sample_drop(catalog_, kStoredRunId));
}

TEST_F(SampleDropTest, SamplesThatAnAcceptedTermIsTakenOffStay) {
  set_state("finished");
  add_model_with_term("SN2");
  const auto plan = plan_sample_drop(catalog_, kStoredRunId);
  ASSERT_FALSE(plan);
  EXPECT_TRUE(base::mentions(plan.error().message, {"SN2", "sensor_lag"}));
  // An older model, also of a unit before its repair, may be verified and reported at any time.
  ASSERT_TRUE(catalog_.add_model("SN2", 0, 1700000001.0, [](std::int32_t) {
    return std::string(R"({"format": "soak-model", "format_version": 1})");
  }));
  ASSERT_TRUE(catalog_.begin_epoch("SN2", "repaired", "ann"));
  EXPECT_FALSE(plan_sample_drop(catalog_, kStoredRunId));
  ASSERT_TRUE(catalog_.add_void({kStoredRunId, "SN2", {}, {}, {}, "not wanted", "ann", 1700000100.0}));
  EXPECT_TRUE(plan_sample_drop(catalog_, kStoredRunId));
}

TEST_F(SampleDropTest, AFileThatALossOfPowerLeftBehindGoesWhenAskedAgain) {
  set_state("finished");
  const auto plan = plan_sample_drop(catalog_, kStoredRunId);
  ASSERT_TRUE(plan);
  ASSERT_TRUE(catalog_.add_sample_drop({kStoredRunId, plan->source, plan->bytes, "room", "ann", 1700000500.0}));
  EXPECT_FALSE(catalog_.runs({}).value().front().samples_dropped) << "its file is there";
  const auto again = plan_sample_drop(catalog_, kStoredRunId);
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_TRUE(drop_samples(catalog_, *again, "another reason", "bob"));
  EXPECT_FALSE(file_is_there());
  EXPECT_EQ(catalog_.runs({}).value().front().samples_dropped->user, "bob");
  EXPECT_FALSE(plan_sample_drop(catalog_, kStoredRunId));
}

TEST_F(SampleDropTest, WhatHasHappenedSinceThePlanIsLookedAtAgain) {
  set_state("finished");
  const auto plan = plan_sample_drop(catalog_, kStoredRunId);
  ASSERT_TRUE(plan);
  add_model_with_term("SN1");
  EXPECT_FALSE(drop_samples(catalog_, *plan, "room", "ann"));
  EXPECT_TRUE(file_is_there());
  EXPECT_FALSE(catalog_.runs({}).value().front().samples_dropped);
}

TEST_F(SampleDropTest, WhoeverReadTheRunBeforeTheDropFindsNoDamage) {
  set_state("finished");
  const db::RunRow before = catalog_.runs({}).value().front();
  const auto plan = plan_sample_drop(catalog_, kStoredRunId);
  ASSERT_TRUE(plan);
  auto other = db::Catalog::open(folder_.path());
  ASSERT_TRUE(other);
  ASSERT_TRUE(drop_samples(*other, *plan, "room", "ann"));
  EXPECT_TRUE(catalog_.check_run_file(before));
  EXPECT_EQ(catalog_.open_run_file(before).error().kind, base::ErrorKind::bad_input);
}

TEST_F(SampleDropTest, ARecordWithoutReasonUserOrSealedRunIsRefused) {
  EXPECT_FALSE(catalog_.add_sample_drop({kStoredRunId, "", 0, "", "ann", 1.0}));
  EXPECT_FALSE(catalog_.add_sample_drop({kStoredRunId, "", 0, "room", "", 1.0}));
  EXPECT_FALSE(catalog_.add_sample_drop({"01990a5d-ac96-774b-bcce-b302099a8057", "", 0, "room", "ann", 1.0}));
  db::RunRow open = db::testing::run_row("01990a5d-ac96-774b-bcce-b302099a8058", "r2");
  open.sealed = false;
  ASSERT_TRUE(catalog_.add_run(open, {}));
  EXPECT_FALSE(catalog_.add_sample_drop({open.run_id, "", 0, "room", "ann", 1.0}));
}

}  // namespace
}  // namespace soak::station
