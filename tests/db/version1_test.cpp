// SPDX-License-Identifier: Apache-2.0
// The files in data/v1 were written by version 1 of the formats and are opened and read by every later program.
// `test_db --gtest_also_run_disabled_tests --gtest_filter=Version1.DISABLED_WritesItsFiles` with SOAK_V1_FOLDER set
// made them; it must not be run again once the formats are released.
#include <SQLiteCpp/Database.h>

#include <array>
#include <cstdlib>

#include "db/detail/schema.h"
#include "tests/db/sample_records.h"

namespace soak::db {
namespace {

using testing::column_of;
using testing::cube_row;
using testing::expect_equal;
using testing::probe_row;
using testing::TempFolder;
using testing::waiver_of;

const std::filesystem::path kFolder = std::filesystem::path(SOAK_TEST_FOLDER) / "db" / "data" / "v1";

constexpr std::size_t kRows = 1200;
constexpr const char* kSecondRun = "01890a5d-ac96-774b-bcce-000000000002";
constexpr const char* kReport = R"({"verdict": "none"})";

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

/// Segments of the second run, two of them with findings.
std::vector<calib::Segment> examined_segments() {
  auto segments = testing::segments_of(testing::run_row(kSecondRun, "r2"));
  segments[0].findings = {
      {"moved", calib::Severity::reject, std::nullopt, "the direction changes by 3 deg"},
      {"dropouts", calib::Severity::warn, calib::Sensor::accel_y, "accel_y: 5.0 % of the samples are missing"}};
  segments[3].findings = {{"stuck", calib::Severity::reject, calib::Sensor::gyro_x, "gyro_x repeats 0.1"}};
  return segments;
}

/// The laboratory's records: a withdrawn entry and its correction, a retired one, a waiver, an ended check standard.
void fill_records(Catalog& catalog) {
  const auto wrong = catalog.add_reference(probe_row("D-K-15048", 1.6e9));
  const auto probe = catalog.add_reference(probe_row());
  const auto cube = catalog.add_reference(cube_row());
  ASSERT_TRUE(wrong && probe && cube);
  ASSERT_TRUE(catalog.withdraw_reference(*wrong, {"day of issue mistyped", "bob", 1.75e9}));
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

/// One of everything that a catalog can hold.
void fill_everything(Catalog& catalog) {
  testing::fill(catalog);
  RunRow run = testing::run_row(kSecondRun, "r2");
  run.purpose = "diagnosis";
  run.created_utc_s += 1.0;
  ASSERT_TRUE(catalog.add_run(run, examined_segments()));
  ASSERT_TRUE(catalog.add_gap_report({"SN1", 2, 1.71e9, kReport}));
  ASSERT_TRUE(catalog.begin_campaign(
      {.name = "night", .procedure = "ramp", .document = "{\"plan\": []}", .created_utc_s = 1700000600.5}));
  ASSERT_TRUE(catalog.complete_step({"night", 3, 1, 1700000650.0, 1700000700.25, "timed out", "", testing::kRunId}));
  ASSERT_TRUE(catalog.set_campaign_state("night", "paused", "door"));
  fill_records(catalog);
}

/// A copy of the catalog in a folder of its own.
class Version1Catalog : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::copy_file(kFolder / "station.db", folder_ / "station.db");
    auto opened = Catalog::open(folder_.path());
    ASSERT_TRUE(opened) << opened.error().message;
    catalog_.emplace(std::move(*opened));
  }

  TempFolder folder_;
  std::optional<Catalog> catalog_;
};

TEST(Version1, RunFileGivesEveryNumber) {
  const auto reader = RunFileReader::open(kFolder / "run.soakrun");
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->info().run_id, testing::run_info().run_id);
  EXPECT_EQ(reader->info().label, testing::run_info().label);
  EXPECT_EQ(reader->info().purpose, "verification");
  ASSERT_EQ(reader->rows(0), kRows);
  EXPECT_EQ(reader->streams()[0].channels, stream().channels);
  const auto expected = columns();
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_TRUE(*reader->read(0, i) == expected[i]) << "channel " << i;
  EXPECT_EQ(reader->events()->front().text, "opened");
  EXPECT_EQ(*reader->content_hash(), "2a880865e3e47678b36a8e5888313d0bfb956037c8b6c3f45cf26fa5b973e552");
  EXPECT_EQ(reader->pyramid(0, 1, 0.0, 12.0, 1)->front().count, kRows);
  EXPECT_TRUE(reader->verify());
}

TEST_F(Version1Catalog, GivesRunsSegmentsAndModels) {
  EXPECT_EQ(catalog_->units()->size(), 1U);
  EXPECT_EQ(*catalog_->campaigns(), (std::vector<std::string>{"c1", "night"}));
  const auto runs = catalog_->runs({});
  ASSERT_EQ(runs->size(), 2U);
  EXPECT_EQ((*runs)[0].content_sha256, std::string(64, 'b'));
  EXPECT_EQ((*runs)[0].purpose, "calibration");
  EXPECT_EQ((*runs)[1].purpose, "diagnosis");
  const auto segments = catalog_->segments(testing::kRunId, "SN1", true);
  ASSERT_TRUE(segments) << segments.error().message;
  const auto all = testing::segments_of(testing::run_row());
  ASSERT_EQ(segments->size(), 3U);
  expect_same((*segments)[0], all[0]);
  expect_same((*segments)[1], all[2]);
  expect_same((*segments)[2], all[3]);
  EXPECT_EQ(catalog_->voids(testing::kRunId)->front().user, "ann");
  EXPECT_EQ((*catalog_->model("SN1"))->version, 2);
  EXPECT_EQ(catalog_->gap_reports("SN1")->front().document, kReport);
  EXPECT_EQ(catalog_->gap_reports("SN1")->front().model_version, 2);
  EXPECT_TRUE(catalog_->verify());
}

TEST_F(Version1Catalog, GetsADigestOfEachRunWhenItIsOpened) {
  const auto runs = catalog_->runs({});
  for (const RunRow& run : *runs) EXPECT_TRUE(catalog_->check_numbers(run)) << run.label;
  SQLite::Database((folder_ / "station.db").string(), SQLite::OPEN_READWRITE)
      .exec("UPDATE segment SET gyro_x_mean = gyro_x_mean + 0.05");
  EXPECT_EQ(Catalog::open(folder_.path())->segments(kSecondRun, "SN1", true).error().kind, base::ErrorKind::corrupt);
}

TEST_F(Version1Catalog, GivesFindings) {
  for (const bool with_blocks : {false, true}) {
    const auto segments = catalog_->segments(kSecondRun, "SN1", with_blocks);
    ASSERT_TRUE(segments) << segments.error().message;
    const auto expected = examined_segments();
    ASSERT_EQ(segments->size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ((*segments)[i].findings, expected[i].findings);
    EXPECT_EQ((*segments)[0].blocks.size(), with_blocks ? 2U : 0U);
  }
}

TEST_F(Version1Catalog, GivesTheJournal) {
  const auto campaign = catalog_->open_campaign();
  ASSERT_TRUE(campaign && *campaign);
  EXPECT_EQ((*campaign)->name, "night");
  EXPECT_EQ((*campaign)->procedure, "ramp");
  EXPECT_EQ((*campaign)->document, "{\"plan\": []}");
  EXPECT_EQ((*campaign)->state, "paused");
  EXPECT_EQ((*campaign)->reason, "door");
  EXPECT_EQ((*campaign)->created_utc_s, 1700000600.5);
  EXPECT_FALSE(*catalog_->campaign("c1"));
  const auto steps = catalog_->completed_steps("night");
  ASSERT_EQ(steps->size(), 1U);
  EXPECT_EQ(steps->front().index, 3);
  EXPECT_EQ(steps->front().attempt, 1);
  EXPECT_EQ(steps->front().ended_utc_s, 1700000700.25);
  EXPECT_EQ(steps->front().outcome, "timed out");
  EXPECT_EQ(steps->front().run_id, testing::kRunId);
}

TEST_F(Version1Catalog, GivesTheLaboratorysRecords) {
  const auto rows = catalog_->references();
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 3U);
  expect_equal((*rows)[0].reference, probe_row("D-K-15048", 1.6e9).reference);
  EXPECT_EQ((*rows)[0].withdrawn.value().reason, "day of issue mistyped");
  EXPECT_EQ((*rows)[0].withdrawn.value().utc_s, 1.75e9);
  expect_equal((*rows)[1].reference, probe_row().reference);
  EXPECT_EQ((*rows)[1].retired.value().reason, "dropped");
  EXPECT_FALSE((*rows)[1].withdrawn);
  expect_equal((*rows)[2].reference, cube_row().reference);
  EXPECT_FALSE((*rows)[2].retired);
  const auto uses = catalog_->campaign_references("c1");
  ASSERT_TRUE(uses) << uses.error().message;
  ASSERT_EQ(uses->size(), 2U);
  EXPECT_FALSE((*uses)[0].waiver);
  expect_equal((*uses)[1].reference, cube_row().reference);
  expect_equal((*uses)[1].waiver.value(), waiver_of((*rows)[2].reference.record_id));
  EXPECT_EQ(catalog_->check_standards()->front().ended.value().user, "bob");
}

TEST_F(Version1Catalog, TakesMoreOfEverything) {
  EXPECT_EQ(catalog_->begin_campaign({.name = "c1", .procedure = "soak"}).error().kind, base::ErrorKind::bad_input);
  ASSERT_TRUE(catalog_->set_campaign_state("night", "finished", ""));
  ASSERT_TRUE(catalog_->begin_campaign({.name = "c2", .procedure = "soak"}));
  EXPECT_TRUE(catalog_->complete_step({.campaign = "c2", .outcome = "done"}));
  EXPECT_TRUE(catalog_->add_run(testing::run_row("01890a5d-ac96-774b-bcce-000000000003", "r3"), {}));
  EXPECT_TRUE(catalog_->add_reference(probe_row("D-K-16000", 1.74e9)));
  EXPECT_TRUE(catalog_->add_gap_report({"SN1", 1, 1.72e9, "{}"}));
  EXPECT_TRUE(catalog_->verify());
}

TEST(Catalog, RefusesADataFolderOfADevelopmentVersionAndLeavesItAsItIs) {
  const TempFolder folder;
  {
    ASSERT_TRUE(Catalog::open(folder.path()));
  }
  for (const int version : {1, 6}) {
    SQLite::Database((folder / "station.db").string(), SQLite::OPEN_READWRITE)
        .exec("PRAGMA application_id = 0x534F4B43; PRAGMA user_version = " + std::to_string(version));
    std::filesystem::remove(folder / "runs");
    const std::string before = testing::bytes_of_file(folder / "station.db");
    const auto refused = Catalog::open(folder.path());
    ASSERT_FALSE(refused) << version;
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(refused.error().where, (folder / "station.db").string());
    EXPECT_EQ(testing::bytes_of_file(folder / "station.db"), before);
    const std::filesystem::directory_iterator files(folder.path());
    EXPECT_EQ(std::distance(begin(files), end(files)), 1);
  }
}

TEST(Migration, BringsAFileForwardOnceAndKeepsItsRows) {
  const TempFolder folder;
  const std::array<schema::Step, 2> steps = {schema::Step{1, "CREATE TABLE t (a); INSERT INTO t VALUES (7);"},
                                             schema::Step{2, "ALTER TABLE t ADD COLUMN b DEFAULT 8;"}};
  const auto connection = sqlite::Connection::open(folder / "x.db", sqlite::Access::read_write);
  ASSERT_TRUE(connection);
  ASSERT_TRUE(schema::migrate(*connection, std::span(steps).first(1), 77));
  EXPECT_EQ(connection->identity()->user_version, 1U);
  for (int opening = 0; opening < 2; ++opening) {
    ASSERT_TRUE(schema::migrate(*connection, steps, 77));
    EXPECT_EQ(connection->identity()->user_version, 2U);
    EXPECT_EQ(connection->identity()->application_id, 77U);
    EXPECT_EQ(connection->database().execAndGet("SELECT a * b FROM t").getInt(), 56);
  }
}

TEST(Migration, LeavesAFileAsItWasWhereAStepFails) {
  const TempFolder folder;
  const std::array<schema::Step, 2> steps = {schema::Step{1, "CREATE TABLE t (a);"}, schema::Step{2, "no SQL"}};
  const auto connection = sqlite::Connection::open(folder / "x.db", sqlite::Access::read_write);
  ASSERT_TRUE(connection);
  EXPECT_FALSE(schema::migrate(*connection, steps, 77));
  EXPECT_EQ(connection->identity()->user_version, 0U);
  EXPECT_EQ(connection->database().execAndGet("SELECT count(*) FROM sqlite_master").getInt(), 0);
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
    fill_everything(*catalog);
  }
  std::filesystem::copy_file(folder / "station.db", std::filesystem::path(target) / "station.db");
}

}  // namespace
}  // namespace soak::db
