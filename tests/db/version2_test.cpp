// SPDX-License-Identifier: Apache-2.0
// The catalog in data/v2 was written by version 2 of its schema and is opened and read by every later version.
// `test_db --gtest_also_run_disabled_tests --gtest_filter=Version2.DISABLED_WritesItsFile` with SOAK_V2_FOLDER set made
// it; it must not be run again once the schema has a version 3. Run files stay at version 1.
#include <cstdlib>

#include "tests/db/sample_catalog.h"

namespace soak::db {
namespace {

using testing::TempFolder;

const std::filesystem::path kFile = std::filesystem::path(SOAK_TEST_FOLDER) / "db" / "data" / "v2" / "station.db";

TEST(Version2, CatalogGivesPurposesAndTheJournal) {
  const TempFolder folder;
  std::filesystem::copy_file(kFile, folder / "station.db");
  const auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  const auto runs = catalog->runs({});
  ASSERT_EQ(runs->size(), 2U);
  EXPECT_EQ((*runs)[0].purpose, "diagnosis");
  EXPECT_EQ((*runs)[1].purpose, "calibration");
  const auto campaign = catalog->open_campaign();
  ASSERT_TRUE(campaign && *campaign);
  EXPECT_EQ((*campaign)->name, "night");
  EXPECT_EQ((*campaign)->procedure, "ramp");
  EXPECT_EQ((*campaign)->document, "{\"plan\": []}");
  EXPECT_EQ((*campaign)->state, "paused");
  EXPECT_EQ((*campaign)->reason, "door");
  EXPECT_EQ((*campaign)->created_utc_s, 1700000600.5);
  const auto steps = catalog->completed_steps("night");
  ASSERT_EQ(steps->size(), 1U);
  EXPECT_EQ(steps->front().index, 3);
  EXPECT_EQ(steps->front().attempt, 1);
  EXPECT_EQ(steps->front().ended_utc_s, 1700000700.25);
  EXPECT_EQ(steps->front().outcome, "timed out");
  EXPECT_EQ(steps->front().run_id, testing::kRunId);
  EXPECT_TRUE(catalog->verify());
}

TEST(Version2, DISABLED_WritesItsFile) {
  const char* const target = std::getenv("SOAK_V2_FOLDER");
  ASSERT_NE(target, nullptr) << "set SOAK_V2_FOLDER to the folder that the file goes to";
  const TempFolder folder;
  {
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog);
    testing::fill(*catalog);
    RunRow run = testing::run_row("01890a5d-ac96-774b-bcce-000000000001", "r2");
    run.purpose = "diagnosis";
    ASSERT_TRUE(catalog->add_run(run, {}));
    ASSERT_TRUE(catalog->begin_campaign(
        {.name = "night", .procedure = "ramp", .document = "{\"plan\": []}", .created_utc_s = 1700000600.5}));
    ASSERT_TRUE(catalog->complete_step({"night", 3, 1, 1700000650.0, 1700000700.25, "timed out", "", testing::kRunId}));
    ASSERT_TRUE(catalog->set_campaign_state("night", "paused", "door"));
  }
  std::filesystem::copy_file(folder / "station.db", std::filesystem::path(target) / "station.db");
}

}  // namespace
}  // namespace soak::db
