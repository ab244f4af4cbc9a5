// SPDX-License-Identifier: Apache-2.0
// The catalog in data/v6 was written by version 6 of its schema and is opened and read by every later version.
// `test_db --gtest_also_run_disabled_tests --gtest_filter=Version6.DISABLED_WritesItsFile` with SOAK_V6_FOLDER set made
// it; it must not be run again once the schema has a version 7. Run files stay at version 1.
#include <SQLiteCpp/Database.h>

#include <cstdlib>

#include "tests/db/sample_records.h"

namespace soak::db {
namespace {

using testing::TempFolder;

const std::filesystem::path kData = std::filesystem::path(SOAK_TEST_FOLDER) / "db" / "data";
constexpr const char* kDocument = R"({"verdict": "none"})";

/// A model with two reports on it.
void fill_reports(Catalog& catalog) {
  const auto version = catalog.add_model("SN1", 0, 1.7e9, [](std::int32_t) { return std::string("{}"); });
  ASSERT_TRUE(version) << version.error().message;
  ASSERT_TRUE(catalog.add_gap_report({"SN1", *version, 1.71e9, kDocument}));
  ASSERT_TRUE(catalog.add_gap_report({"SN1", *version, 1.72e9, "{}"}));
}

void expect_reports(const Catalog& catalog) {
  const auto reports = catalog.gap_reports("SN1");
  ASSERT_TRUE(reports) << reports.error().message;
  ASSERT_EQ(reports->size(), 2U);
  EXPECT_EQ(reports->front().document, kDocument);
  EXPECT_EQ(reports->front().created_utc_s, 1.71e9);
  EXPECT_EQ(reports->front().model_version, catalog.model("SN1")->value().version);
  EXPECT_TRUE(catalog.gap_reports("another")->empty());
  EXPECT_TRUE(catalog.verify());
}

TEST(Version6, CatalogGivesGapReports) {
  const TempFolder folder;
  std::filesystem::copy_file(kData / "v6" / "station.db", folder / "station.db");
  const auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  expect_reports(*catalog);
}

TEST(Version6, OlderCatalogsTakeGapReportsOnceTheyAreBroughtForward) {
  for (const char* version : {"v1", "v2", "v3", "v4", "v5"}) {
    const TempFolder folder;
    std::filesystem::copy_file(kData / version / "station.db", folder / "station.db");
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog) << version << ": " << catalog.error().message;
    fill_reports(*catalog);
    expect_reports(*catalog);
  }
}

TEST(Version6, GapReportsAreNeverChanged) {
  const TempFolder folder;
  auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog);
  testing::fill(*catalog);
  fill_reports(*catalog);
  SQLite::Database raw((folder / "station.db").string(), SQLite::OPEN_READWRITE);
  EXPECT_THROW(raw.exec("UPDATE gap_report SET document = ''"), SQLite::Exception);
  EXPECT_THROW(raw.exec("DELETE FROM gap_report"), SQLite::Exception);
  expect_reports(*catalog);
}

TEST(Version6, AReportNeedsItsModel) {
  const TempFolder folder;
  auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog);
  testing::fill(*catalog);
  const auto refused = catalog->add_gap_report({"SN1", 77, 1.7e9, "{}"});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  EXPECT_NE(refused.error().message.find("77"), std::string::npos);
}

TEST(Version6, DISABLED_WritesItsFile) {
  const char* const target = std::getenv("SOAK_V6_FOLDER");
  ASSERT_NE(target, nullptr) << "set SOAK_V6_FOLDER to the folder that the file goes to";
  const TempFolder folder;
  {
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog);
    testing::fill(*catalog);
    fill_reports(*catalog);
  }
  std::filesystem::copy_file(folder / "station.db", std::filesystem::path(target) / "station.db");
}

}  // namespace
}  // namespace soak::db
