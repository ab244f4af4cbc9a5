// SPDX-License-Identifier: Apache-2.0
// The catalog in data/v5 was written by version 5 of its schema and is opened and read by every later version.
// `test_db --gtest_also_run_disabled_tests --gtest_filter=Version5.DISABLED_WritesItsFile` with SOAK_V5_FOLDER set made
// it; it must not be run again once the schema has a version 6. Run files stay at version 1.
#include <cstdlib>

#include "tests/db/sample_records.h"

namespace soak::db {
namespace {

using testing::cube_row;
using testing::expect_equal;
using testing::probe_row;
using testing::TempFolder;

const std::filesystem::path kData = std::filesystem::path(SOAK_TEST_FOLDER) / "db" / "data";

/// A wrong entry that is withdrawn, and the one that corrects it.
void fill_withdrawal(Catalog& catalog) {
  const auto wrong = catalog.add_reference(probe_row("D-K-16000", 1.74e9));
  ASSERT_TRUE(wrong) << wrong.error().message;
  ASSERT_TRUE(catalog.withdraw_reference(*wrong, {"day of issue mistyped", "bob", 1.75e9}));
  ASSERT_TRUE(catalog.add_reference(probe_row("D-K-16000", 1.73e9)));
}

void expect_withdrawal(const Catalog& catalog) {
  const auto rows = catalog.references();
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_GE(rows->size(), 2U);
  const ReferenceRow& wrong = (*rows)[rows->size() - 2];
  expect_equal(wrong.reference, probe_row("D-K-16000", 1.74e9).reference);
  ASSERT_TRUE(wrong.withdrawn);
  EXPECT_EQ(wrong.withdrawn->reason, "day of issue mistyped");
  EXPECT_EQ(wrong.withdrawn->user, "bob");
  EXPECT_EQ(wrong.withdrawn->utc_s, 1.75e9);
  EXPECT_FALSE(rows->back().withdrawn);
  EXPECT_FALSE(catalog.runs({})->empty());
  EXPECT_TRUE(catalog.verify());
}

TEST(Version5, CatalogGivesWithdrawnEntries) {
  const TempFolder folder;
  std::filesystem::copy_file(kData / "v5" / "station.db", folder / "station.db");
  const auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  expect_withdrawal(*catalog);
}

TEST(Version5, OlderCatalogsTakeWithdrawalsOnceTheyAreBroughtForward) {
  for (const char* version : {"v1", "v2", "v3", "v4"}) {
    const TempFolder folder;
    std::filesystem::copy_file(kData / version / "station.db", folder / "station.db");
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog) << version << ": " << catalog.error().message;
    const auto before = catalog->references();
    ASSERT_TRUE(before) << version;
    for (const ReferenceRow& row : *before) EXPECT_FALSE(row.withdrawn) << version;
    fill_withdrawal(*catalog);
    expect_withdrawal(*catalog);
  }
}

TEST(Version5, DISABLED_WritesItsFile) {
  const char* const target = std::getenv("SOAK_V5_FOLDER");
  ASSERT_NE(target, nullptr) << "set SOAK_V5_FOLDER to the folder that the file goes to";
  const TempFolder folder;
  {
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog);
    testing::fill(*catalog);
    fill_withdrawal(*catalog);
  }
  std::filesystem::copy_file(folder / "station.db", std::filesystem::path(target) / "station.db");
}

}  // namespace
}  // namespace soak::db
