// SPDX-License-Identifier: Apache-2.0
#include "station/lab/stored.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <tuple>

#include "tests/db/sample_catalog.h"
#include "tests/db/support.h"

namespace soak::station {
namespace {

using nlohmann::json;

class Stored : public ::testing::Test {
 protected:
  void add_run(const std::string& campaign, const std::string& label, double created_utc_s,
               const std::string& purpose = "calibration") {
    db::RunRow run = db::testing::run_row("00000000-0000-7000-8000-" + std::to_string(100000000000 + ++number_), label);
    run.campaign = campaign;
    run.purpose = purpose;
    run.created_utc_s = created_utc_s;
    ASSERT_TRUE(catalog_.ensure_unit(run.unit, "mti-300"));
    ASSERT_TRUE(catalog_.ensure_campaign(campaign, run.procedure));
    const auto added = catalog_.add_run(run, {});
    ASSERT_TRUE(added) << added.error().message;
    last_run_id_ = run.run_id;
  }

  json document() { return stored_document(config_, catalog_).value(); }

  std::uint64_t number_ = 0;
  std::string last_run_id_;
  StationConfig config_;
  db::testing::TempFolder folder_;
  db::Catalog catalog_ = db::Catalog::open(folder_.path()).value();
};

TEST_F(Stored, AnEmptyStationHasItsSlotsAndNothingElse) {
  config_.slots = {{.name = "1", .unit = "SN1", .unit_type = "mti-300"}, {.name = "2"}};
  EXPECT_EQ(document(), json::parse(R"({"slots": [{"name": "1", "unit": "SN1", "unit_type": "mti-300", "last_unit": ""},
                                                   {"name": "2", "unit": "", "unit_type": "", "last_unit": ""}],
                                         "units": [], "campaigns": []})"));
}

TEST_F(Stored, RunsCountUnlessTheyAreVoidOrPreflights) {
  add_run("spring", "P00", 1e9, "diagnosis");
  add_run("spring", "R01", 1e9 + 10);
  add_run("spring", "R02", 1e9 + 20);
  add_run("spring", "R03", 1e9 + 30);
  ASSERT_TRUE(
      catalog_.add_void({.run_id = last_run_id_, .unit = "SN1", .reason = "a cable", .user = "eva", .utc_s = 2e9}));
  const json stored = document();
  ASSERT_EQ(stored["units"].size(), 1);
  EXPECT_EQ(stored["units"][0],
            json({{"serial", "SN1"}, {"type", "mti-300"}, {"runs", 2}, {"newest_run_utc_s", 1e9 + 20}}));
  ASSERT_EQ(stored["campaigns"].size(), 1);
  EXPECT_EQ(stored["campaigns"][0]["runs"], 2);
  EXPECT_EQ(stored["campaigns"][0]["units"], json::array({"SN1"}));
}

TEST_F(Stored, AUnitThatWasNeverRecordedIsListed) {
  ASSERT_TRUE(catalog_.ensure_unit("SN9", "generic"));
  EXPECT_EQ(document()["units"][0],
            json({{"serial", "SN9"}, {"type", "generic"}, {"runs", 0}, {"newest_run_utc_s", nullptr}}));
}

TEST_F(Stored, ASlotHasTheUnitThatItHeldInTheNewestCampaign) {
  config_.slots = {{.name = "1"}, {.name = "2"}};
  for (const auto& [name, begun_utc_s, unit] : {std::tuple("new", 2e9, "SN2"), std::tuple("old", 1e9, "SN1")}) {
    db::CampaignRow row;
    row.name = name;
    row.procedure = "soak";
    row.document =
        json{{"procedure_file", "p"}, {"procedure_text", ""}, {"units", {{"1", unit}}}, {"user", "eva"}}.dump();
    row.created_utc_s = row.updated_utc_s = begun_utc_s;
    ASSERT_TRUE(catalog_.begin_campaign(row));
    ASSERT_TRUE(catalog_.set_campaign_state(name, "finished", "all steps are done"));
  }
  const json slots = document()["slots"];
  EXPECT_EQ(slots[0]["last_unit"], "SN2");
  EXPECT_EQ(slots[1]["last_unit"], "");
}

TEST_F(Stored, CampaignsComeNewestFirstWithTheirStates) {
  add_run("imported", "R01", 1.5e9);
  for (const auto& [name, begun_utc_s] : {std::pair("old", 1e9), std::pair("new", 2e9)}) {
    db::CampaignRow row;
    row.name = name;
    row.procedure = "soak";
    row.document = "{}";
    row.created_utc_s = row.updated_utc_s = begun_utc_s;
    ASSERT_TRUE(catalog_.begin_campaign(row));
    ASSERT_TRUE(catalog_.set_campaign_state(name, "failed", "no air"));
  }
  const json campaigns = document()["campaigns"];
  ASSERT_EQ(campaigns.size(), 3);
  EXPECT_EQ(campaigns[0]["name"], "new");
  EXPECT_EQ(campaigns[0]["state"], "failed");
  EXPECT_EQ(campaigns[0]["reason"], "no air");
  EXPECT_EQ(campaigns[0]["begun_utc_s"], 2e9);
  EXPECT_EQ(campaigns[1]["name"], "imported");
  EXPECT_EQ(campaigns[1]["state"], nullptr);
  EXPECT_EQ(campaigns[2]["name"], "old");
}

}  // namespace
}  // namespace soak::station
