// SPDX-License-Identifier: Apache-2.0
// Files written by version 1 of the formats lie in data/v1 and are opened and read by every later version.
// `test_db --gtest_also_run_disabled_tests --gtest_filter=Version1.DISABLED_WritesItsFiles` with SOAK_V1_FOLDER set
// made them; it must not be run again once the formats have a version 2.
#include <SQLiteCpp/Database.h>

#include <cstdlib>

#include "tests/db/sample_catalog.h"

namespace soak::db {
namespace {

using testing::column_of;
using testing::TempFolder;

const std::filesystem::path kFolder = std::filesystem::path(SOAK_TEST_FOLDER) / "db" / "data" / "v1";

constexpr std::size_t kRows = 1200;

StreamInfo stream() {
  using testing::channel;
  StreamInfo info{"imu",
                  "SN1",
                  {channel("t_s", SampleType::f64, "s"), channel("gyro_x", SampleType::i16, "dps"),
                   channel("temp_c", SampleType::f32, "c"), channel("position", SampleType::u8, "label")}};
  info.channels[1].scale = 0.0625;
  info.channels[2].source_name = "Temp";
  info.channels[3].labels = {"+X", "-X"};
  return info;
}

/// Numbers that need no random generator: whoever reads the files can compute them.
std::vector<Column> columns() {
  std::vector<double> t_s;
  std::vector<std::int16_t> gyro;
  std::vector<float> temp_c;
  std::vector<std::uint8_t> position;
  std::vector<std::uint8_t> present;
  for (std::size_t i = 0; i < kRows; ++i) {
    t_s.push_back(0.01 * static_cast<double>(i));
    gyro.push_back(static_cast<std::int16_t>(static_cast<int>(i * i % 1009) - 504));
    present.push_back(i % 10 == 0 ? 1 : 0);
    temp_c.push_back(i % 10 == 0 ? 25.0F + 0.001F * static_cast<float>(i) : 0.0F);
    position.push_back(i < 600 ? 0 : 1);
  }
  return {column_of(t_s), column_of(gyro), column_of(temp_c, present), column_of(position)};
}

TEST(Version1, RunFileGivesEveryNumber) {
  const auto reader = RunFileReader::open(kFolder / "run.soakrun");
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->info().run_id, testing::run_info().run_id);
  EXPECT_EQ(reader->info().label, testing::run_info().label);
  EXPECT_EQ(reader->info().purpose, "calibration") << "the file says nothing of it";
  ASSERT_EQ(reader->rows(0), kRows);
  EXPECT_EQ(reader->streams()[0].channels, stream().channels);
  const auto expected = columns();
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_TRUE(*reader->read(0, i) == expected[i]) << "channel " << i;
  EXPECT_EQ(reader->events()->front().text, "opened");
  EXPECT_EQ(*reader->content_hash(), "2a880865e3e47678b36a8e5888313d0bfb956037c8b6c3f45cf26fa5b973e552");
  EXPECT_EQ(reader->pyramid(0, 1, 0.0, 12.0, 1)->front().count, kRows);
  EXPECT_TRUE(reader->verify());
}

TEST(Version1, CatalogGivesEveryRow) {
  const TempFolder folder;
  std::filesystem::copy_file(kFolder / "station.db", folder / "station.db");
  const auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  EXPECT_EQ(catalog->units()->size(), 1U);
  EXPECT_EQ(*catalog->campaigns(), std::vector<std::string>{"c1"});
  EXPECT_EQ(catalog->runs({})->front().content_sha256, std::string(64, 'b'));
  const auto segments = catalog->segments(testing::kRunId, "SN1", true);
  ASSERT_TRUE(segments) << segments.error().message;
  const auto all = testing::segments_of(testing::run_row());
  ASSERT_EQ(segments->size(), 3U);
  testing::expect_equal((*segments)[0], all[0]);
  testing::expect_equal((*segments)[1], all[2]);
  testing::expect_equal((*segments)[2], all[3]);
  EXPECT_EQ(catalog->voids(testing::kRunId)->front().user, "ann");
  EXPECT_EQ((*catalog->model("SN1"))->version, 2);
  EXPECT_EQ(catalog->events()->back().text, "looks good");
  EXPECT_TRUE(catalog->verify());
}

TEST(Version1, CatalogIsBroughtForwardOnceAndTakesNewKindsOfRows) {
  const TempFolder folder;
  std::filesystem::copy_file(kFolder / "station.db", folder / "station.db");
  const auto version = [&] {
    return SQLite::Database((folder / "station.db").string()).execAndGet("PRAGMA user_version").getInt();
  };
  ASSERT_EQ(version(), 1);
  for (int opening = 0; opening < 2; ++opening) {
    const auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog) << catalog.error().message;
    EXPECT_EQ(version(), Catalog::kSchemaVersion);
    EXPECT_EQ(catalog->runs({})->front().purpose, "calibration");
    EXPECT_FALSE(*catalog->campaign("c1"));
  }
  auto catalog = Catalog::open(folder.path());
  // The campaign has a run: its name is taken although it has no journal.
  EXPECT_EQ(catalog->begin_campaign({.name = "c1", .procedure = "soak"}).error().kind, base::ErrorKind::bad_input);
  ASSERT_TRUE(catalog->begin_campaign({.name = "c2", .procedure = "soak"}));
  EXPECT_TRUE(catalog->complete_step({.campaign = "c2", .outcome = "done"}));
  EXPECT_TRUE(catalog->verify());
}

TEST(Version1, RunsOfVerificationProceduresAreForVerification) {
  const TempFolder folder;
  std::filesystem::copy_file(kFolder / "station.db", folder / "station.db");
  // As version 1 wrote them.
  SQLite::Database((folder / "station.db").string(), SQLite::OPEN_READWRITE)
      .exec(
          "INSERT INTO campaign VALUES ('check', 'verification');"
          "INSERT INTO run SELECT 'another', unit, 'check', label, 'verification', epoch, created_utc_s + 1, "
          "clock_rate, simulated, sealed, file_name, file_sha256, content_sha256, latitude_deg, height_m, "
          "azimuth_deg, gravity_mps2, row_count, duration_s FROM run");
  const auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  const auto runs = catalog->runs({});
  ASSERT_EQ(runs->size(), 2U);
  EXPECT_EQ((*runs)[0].purpose, "calibration");
  EXPECT_EQ((*runs)[1].purpose, "verification");
}

TEST(Version1, DISABLED_WritesItsFiles) {
  const char* const target = std::getenv("SOAK_V1_FOLDER");
  ASSERT_NE(target, nullptr) << "set SOAK_V1_FOLDER to the folder that the files go to";
  auto writer = RunFileWriter::create(std::filesystem::path(target) / "run.soakrun", testing::run_info());
  ASSERT_TRUE(writer) << writer.error().message;
  ASSERT_TRUE(writer->add_stream(stream()));
  ASSERT_TRUE(writer->append(0, columns()));
  ASSERT_TRUE(writer->add_event(1.5, "door", "opened"));
  ASSERT_TRUE(writer->seal());
  const TempFolder folder;
  {
    auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog);
    testing::fill(*catalog);
  }
  std::filesystem::copy_file(folder / "station.db", std::filesystem::path(target) / "station.db");
}

}  // namespace
}  // namespace soak::db
