// SPDX-License-Identifier: Apache-2.0
// The catalog in data/v3 was written by version 3 of its schema and is opened and read by every later version.
// `test_db --gtest_also_run_disabled_tests --gtest_filter=Version3.DISABLED_WritesItsFile` with SOAK_V3_FOLDER set made
// it; it must not be run again once the schema has a version 4. Run files stay at version 1.
#include <cstdlib>

#include "tests/db/sample_catalog.h"

namespace soak::db {
namespace {

using testing::TempFolder;

const std::filesystem::path kFile = std::filesystem::path(SOAK_TEST_FOLDER) / "db" / "data" / "v3" / "station.db";
constexpr const char* kSecondRun = "01890a5d-ac96-774b-bcce-000000000002";

/// Segments of a second run, the first with two findings.
std::vector<calib::Segment> examined_segments() {
  auto segments = testing::segments_of(testing::run_row(kSecondRun, "r2"));
  segments[0].findings = {
      {"moved", calib::Severity::reject, std::nullopt, "the direction changes by 3 deg"},
      {"dropouts", calib::Severity::warn, calib::Sensor::accel_y, "accel_y: 5.0 % of the samples are missing"}};
  segments[3].findings = {{"stuck", calib::Severity::reject, calib::Sensor::gyro_x, "gyro_x repeats 0.1"}};
  return segments;
}

void expect_everything(const Catalog& catalog) {
  for (const bool with_blocks : {false, true}) {
    const auto segments = catalog.segments(kSecondRun, "SN1", with_blocks);
    ASSERT_TRUE(segments) << segments.error().message;
    const auto expected = examined_segments();
    ASSERT_EQ(segments->size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ((*segments)[i].findings, expected[i].findings);
    EXPECT_EQ((*segments)[0].blocks.size(), with_blocks ? 2U : 0U);
  }
  EXPECT_TRUE(catalog.segments(testing::kRunId, "SN1", false)->front().findings.empty());
  EXPECT_TRUE(catalog.verify());
}

TEST(Version3, CatalogGivesFindings) {
  const TempFolder folder;
  std::filesystem::copy_file(kFile, folder / "station.db");
  const auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  expect_everything(*catalog);
}

TEST(Version3, AnOlderCatalogTakesFindingsOnceItIsBroughtForward) {
  const TempFolder folder;
  std::filesystem::copy_file(kFile.parent_path().parent_path() / "v1" / "station.db", folder / "station.db");
  auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  ASSERT_TRUE(catalog->add_run(testing::run_row(kSecondRun, "r2"), examined_segments()));
  expect_everything(*catalog);
}

TEST(Version3, DISABLED_WritesItsFile) {
  const char* const target = std::getenv("SOAK_V3_FOLDER");
  ASSERT_NE(target, nullptr) << "set SOAK_V3_FOLDER to the folder that the file goes to";
  const TempFolder folder;
  {
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog);
    testing::fill(*catalog);
    ASSERT_TRUE(catalog->add_run(testing::run_row(kSecondRun, "r2"), examined_segments()));
  }
  std::filesystem::copy_file(folder / "station.db", std::filesystem::path(target) / "station.db");
}

}  // namespace
}  // namespace soak::db
