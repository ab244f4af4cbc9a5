// SPDX-License-Identifier: Apache-2.0
// The catalog in data/v4 was written by version 4 of its schema and is opened and read by every later version.
// `test_db --gtest_also_run_disabled_tests --gtest_filter=Version4.DISABLED_WritesItsFile` with SOAK_V4_FOLDER set made
// it; it must not be run again once the schema has a version 5. Run files stay at version 1.
#include <cstdlib>

#include "tests/db/sample_records.h"

namespace soak::db {
namespace {

using testing::cube_row;
using testing::expect_equal;
using testing::probe_row;
using testing::TempFolder;
using testing::waiver_of;

const std::filesystem::path kData = std::filesystem::path(SOAK_TEST_FOLDER) / "db" / "data";

/// Two references of which one is retired, a waiver, what campaign c1 was measured with, a check standard that ended.
void fill_records(Catalog& catalog) {
  const auto probe = catalog.add_reference(probe_row());
  const auto cube = catalog.add_reference(cube_row());
  ASSERT_TRUE(probe && cube);
  ASSERT_TRUE(catalog.add_waiver(waiver_of(*cube)));
  calib::ReferenceUse first{probe_row().reference, std::nullopt};
  first.reference.record_id = *probe;
  calib::ReferenceUse second{cube_row().reference, waiver_of(*cube)};
  second.reference.record_id = *cube;
  ASSERT_TRUE(catalog.add_campaign_references("c1", {first, second}));
  ASSERT_TRUE(catalog.retire_reference(*probe, {"dropped", "bob", 1.75e9}));
  const auto standard =
      catalog.add_check_standard({.unit = "SN1", .since_utc_s = 1.7e9, .reason = "stable", .user = "ann"});
  ASSERT_TRUE(standard);
  ASSERT_TRUE(catalog.end_check_standard(*standard, {"broken", "bob", 1.71e9}));
}

void expect_everything(const Catalog& catalog) {
  const auto rows = catalog.references();
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 2U);
  expect_equal((*rows)[0].reference, probe_row().reference);
  EXPECT_EQ((*rows)[0].retired->reason, "dropped");
  expect_equal((*rows)[1].reference, cube_row().reference);
  EXPECT_FALSE((*rows)[1].retired);
  const auto uses = catalog.campaign_references("c1");
  ASSERT_TRUE(uses) << uses.error().message;
  ASSERT_EQ(uses->size(), 2U);
  EXPECT_FALSE((*uses)[0].waiver);
  expect_equal((*uses)[1].reference, cube_row().reference);
  expect_equal((*uses)[1].waiver.value(), waiver_of((*rows)[1].reference.record_id));
  EXPECT_EQ(catalog.check_standards()->front().ended->user, "bob");
  EXPECT_FALSE(catalog.runs({})->empty());
  EXPECT_TRUE(catalog.verify());
}

TEST(Version4, CatalogGivesTheLaboratorysRecords) {
  const TempFolder folder;
  std::filesystem::copy_file(kData / "v4" / "station.db", folder / "station.db");
  const auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  expect_everything(*catalog);
}

TEST(Version4, OlderCatalogsTakeRecordsOnceTheyAreBroughtForward) {
  for (const char* version : {"v1", "v2", "v3"}) {
    const TempFolder folder;
    std::filesystem::copy_file(kData / version / "station.db", folder / "station.db");
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog) << version << ": " << catalog.error().message;
    EXPECT_TRUE(catalog->references()->empty()) << version;
    EXPECT_TRUE(catalog->campaign_references("c1")->empty()) << version;
    fill_records(*catalog);
    expect_everything(*catalog);
  }
}

TEST(Version4, DISABLED_WritesItsFile) {
  const char* const target = std::getenv("SOAK_V4_FOLDER");
  ASSERT_NE(target, nullptr) << "set SOAK_V4_FOLDER to the folder that the file goes to";
  const TempFolder folder;
  {
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog);
    testing::fill(*catalog);
    fill_records(*catalog);
  }
  std::filesystem::copy_file(folder / "station.db", std::filesystem::path(target) / "station.db");
}

}  // namespace
}  // namespace soak::db
