// SPDX-License-Identifier: Apache-2.0
#include "db/catalog/catalog.h"

#include <SQLiteCpp/Database.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "base/text.h"
#include "base/units.h"
#include "tests/db/sample_catalog.h"

namespace soak::db {
namespace {

using testing::fill;
using testing::kRunId;
using testing::run_row;
using testing::segment;
using testing::segments_of;
using testing::TempFolder;

class CatalogTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(catalog_) << catalog_.error().message; }

  [[nodiscard]] SQLite::Database raw() const {
    return SQLite::Database((folder_ / "station.db").string(), SQLite::OPEN_READWRITE);
  }

  TempFolder folder_;
  base::Result<Catalog> catalog_ = Catalog::open(folder_.path());
};

template <class T>
bool is_bad_input(const base::Result<T>& result) {
  return !result && result.error().kind == base::ErrorKind::bad_input && !result.error().message.empty();
}

/// What the sqlite3 program says of a catalog; it is the last to close the file unless we hold a lock on it.
std::string ask_another_program(const std::filesystem::path& folder, const std::string& sql) {
  const std::string command = "sqlite3 '" + (folder / "station.db").string() + "' \"" + sql + "\"";
  FILE* const pipe = ::popen(command.c_str(), "r");
  std::array<char, 64> line{};
  const char* const answer = std::fgets(line.data(), static_cast<int>(line.size()), pipe);
  EXPECT_EQ(::pclose(pipe), 0) << command;
  return answer == nullptr ? std::string() : std::string(answer);
}

/// Locks are those of a process: a second connection must not take them from the first one, or the next program that
/// closes the catalog removes its -wal file, and what is written from then on goes nowhere.
TEST_F(CatalogTest, MayBeOpenedAgainByTheProcessThatHasItOpen) {
  ASSERT_TRUE(catalog_->log_event({1.0, "kind", "subject", "before"}));
  auto second = Catalog::open(folder_.path());
  ASSERT_TRUE(second);
  EXPECT_EQ(ask_another_program(folder_.path(), "SELECT text FROM event WHERE kind = 'kind'"), "before\n");
  ASSERT_TRUE(catalog_->log_event({2.0, "kind", "subject", "first"}));
  ASSERT_TRUE(second->log_event({3.0, "kind", "subject", "second"}));
  EXPECT_EQ(ask_another_program(folder_.path(), "SELECT count(*) FROM event WHERE kind = 'kind'"), "3\n");
}

TEST_F(CatalogTest, GivesBackRunsAndSegmentsExactly) {
  fill(*catalog_);
  const auto reopened = Catalog::open(folder_.path());
  ASSERT_TRUE(reopened);
  const auto runs = reopened->runs({});
  ASSERT_EQ(runs->size(), 1U);
  const RunRow& run = runs->front();
  const RunRow expected = run_row();
  EXPECT_EQ(run.run_id, expected.run_id);
  EXPECT_EQ(run.campaign, expected.campaign);
  EXPECT_EQ(run.label, expected.label);
  EXPECT_EQ(run.procedure, expected.procedure);
  EXPECT_EQ(run.created_utc_s, expected.created_utc_s);
  EXPECT_EQ(run.clock_rate, 20.0);
  EXPECT_TRUE(run.simulated);
  EXPECT_TRUE(run.sealed);
  EXPECT_FALSE(run.voided);
  EXPECT_EQ(run.file_sha256, expected.file_sha256);
  EXPECT_EQ(run.content_sha256, expected.content_sha256);
  EXPECT_EQ(run.site, expected.site);
  EXPECT_EQ(run.rows, expected.rows);
  EXPECT_EQ(run.duration_s, expected.duration_s);
  EXPECT_EQ(reopened->run_file_path(run), folder_.path() / "runs" / run.file_name);

  const auto segments = reopened->segments(kRunId, "SN1", true);
  ASSERT_TRUE(segments) << segments.error().message;
  const auto all = segments_of(expected);
  ASSERT_EQ(segments->size(), 3U);  // "-X" is void
  expect_same((*segments)[0], all[0]);
  expect_same((*segments)[1], all[2]);
  expect_same((*segments)[2], all[3]);
  EXPECT_TRUE(reopened->segments(kRunId, "SN1", false)->front().blocks.empty());
  EXPECT_TRUE(reopened->verify());
}

TEST_F(CatalogTest, KeepsNumbersThatAreNone) {
  fill(*catalog_);
  RunRow run = run_row("01890a5d-ac96-774b-bcce-000000000001", "nan");
  auto odd = segment(run.run_id, run.unit, 0, "+Z", 0, 0.0);
  odd.plateau_c.reset();
  odd.sensor_temp_c[2] = std::nan("");
  odd.sensor[4] = {0, std::nan(""), INFINITY, -0.0};
  ASSERT_TRUE(catalog_->add_run(run, {odd}));
  const auto read = catalog_->segments(run.run_id, run.unit, true);
  EXPECT_FALSE(read->front().plateau_c);
  EXPECT_TRUE(std::isnan(read->front().sensor_temp_c[2]));
  EXPECT_TRUE(std::isnan(read->front().sensor[4].mean));
  EXPECT_EQ(read->front().sensor[4].variance, INFINITY);
}

TEST_F(CatalogTest, AddsARunWithAllSegmentsOrNothing) {
  fill(*catalog_);
  const auto events = catalog_->events()->size();
  const RunRow run = run_row("01890a5d-ac96-774b-bcce-000000000001", "r2");
  auto segments = segments_of(run);
  segments.push_back(segments.front());
  EXPECT_TRUE(is_bad_input(catalog_->add_run(run, segments)));
  EXPECT_TRUE(is_bad_input(catalog_->add_run(run, segments_of(run_row()))));
  EXPECT_EQ(catalog_->runs({})->size(), 1U);
  EXPECT_EQ(catalog_->events()->size(), events);
}

TEST_F(CatalogTest, RefusesRunsThatContradictTheCatalog) {
  fill(*catalog_);
  EXPECT_TRUE(is_bad_input(catalog_->add_run(run_row(), {})));
  EXPECT_TRUE(is_bad_input(catalog_->add_run(run_row("01890a5d-ac96-774b-bcce-000000000001", "r1"), {})));
  EXPECT_TRUE(is_bad_input(catalog_->add_run(run_row("01890a5d-ac96-774b-bcce-000000000001", "r2", "SN9"), {})));
  RunRow stray = run_row("01890a5d-ac96-774b-bcce-000000000001", "r2");
  stray.campaign = "c9";
  EXPECT_TRUE(is_bad_input(catalog_->add_run(stray, {})));
  EXPECT_TRUE(is_bad_input(catalog_->segments("no such run", "SN1", false)));
}

TEST_F(CatalogTest, KeepsThePurposeOfARunAndRefusesAnUnknownOne) {
  fill(*catalog_);
  EXPECT_EQ(catalog_->runs({})->front().purpose, "calibration");
  RunRow run = run_row("01890a5d-ac96-774b-bcce-000000000001", "r2");
  for (const char* purpose : {"", "test", "Calibration"}) {
    run.purpose = purpose;
    EXPECT_TRUE(is_bad_input(catalog_->add_run(run, {}))) << purpose;
  }
  run.purpose = "diagnosis";
  ASSERT_TRUE(catalog_->add_run(run, {}));
  EXPECT_EQ(catalog_->runs({.unit = {}, .campaign = {}, .run = "r2"})->front().purpose, "diagnosis");
}

TEST_F(CatalogTest, FindsRunsByIdPrefixLabelUnitAndCampaign) {
  fill(*catalog_);
  ASSERT_TRUE(catalog_->ensure_unit("SN2", "generic"));
  ASSERT_TRUE(catalog_->ensure_campaign("c2", "soak"));
  RunRow second = run_row("01890a5d-ac96-774b-bcce-b302099a9999", "01890a5d");  // a label that looks like a prefix
  second.campaign = "c2";
  second.created_utc_s += 10.0;
  ASSERT_TRUE(catalog_->add_run(second, {}));
  RunRow partner = run_row(kRunId, "r1", "SN2");
  ASSERT_TRUE(catalog_->add_run(partner, {}));
  const auto count = [&](RunFilter filter) {
    const auto runs = catalog_->runs(filter);
    return runs ? static_cast<int>(runs->size()) : -1;
  };
  EXPECT_EQ(count({}), 3);
  EXPECT_EQ(count({.unit = "SN1", .campaign = {}, .run = {}}), 2);
  EXPECT_EQ(count({.unit = {}, .campaign = "c2", .run = {}}), 1);
  EXPECT_EQ(count({.unit = {}, .campaign = {}, .run = kRunId}), 2);  // both units of one run
  EXPECT_EQ(count({.unit = {}, .campaign = {}, .run = "r1"}), 2);
  EXPECT_EQ(count({.unit = {}, .campaign = {}, .run = "01890a5d"}), 1);  // the label wins
  EXPECT_EQ(count({.unit = {}, .campaign = {}, .run = "01890a5d-ac96-774b-bcce-b302099a9"}), 1);
  EXPECT_EQ(count({.unit = {}, .campaign = {}, .run = "01890a5d-ac96"}), -1);  // two runs start like that
  EXPECT_EQ(count({.unit = {}, .campaign = "c2", .run = "01890a5d-ac96"}), 1);
  EXPECT_EQ(count({.unit = {}, .campaign = {}, .run = "01890"}), 0);  // too short for a prefix
  EXPECT_EQ(count({.unit = {}, .campaign = {}, .run = "_1890a5d"}), 0);
  EXPECT_TRUE(is_bad_input(catalog_->runs({.unit = {}, .campaign = {}, .run = "01890a5d-ac96"})));
}

TEST_F(CatalogTest, WithdrawsSegmentsPositionsVisitsAndRuns) {
  fill(*catalog_);
  const auto left = [&] { return catalog_->segments(kRunId, "SN1", false)->size(); };
  const auto record = [](std::optional<std::int32_t> visit, std::optional<std::string> position) {
    return VoidRecord{kRunId, "SN1", visit, std::move(position), {}, "bad", "bob", 5.0};
  };
  EXPECT_EQ(left(), 3U);
  ASSERT_TRUE(catalog_->add_void(record(0, "+X")));  // both attempts
  EXPECT_EQ(left(), 1U);
  ASSERT_TRUE(catalog_->add_void(record(1, {})));
  EXPECT_EQ(left(), 0U);
  EXPECT_FALSE(catalog_->runs({})->front().voided);
  ASSERT_TRUE(catalog_->add_void(record({}, {})));
  EXPECT_TRUE(catalog_->runs({})->front().voided);
  const auto records = catalog_->voids(kRunId);
  ASSERT_EQ(records->size(), 4U);
  EXPECT_EQ((*records)[0].reason, "fixture slipped");
  EXPECT_EQ((*records)[0].attempt, 0);
  EXPECT_EQ((*records)[1].position, "+X");
  EXPECT_FALSE((*records)[3].visit);
}

TEST_F(CatalogTest, RefusesVoidRecordsWithoutReasonOrTarget) {
  fill(*catalog_);
  EXPECT_TRUE(is_bad_input(catalog_->add_void({kRunId, "SN1", {}, {}, {}, "", "bob", 5.0})));
  EXPECT_TRUE(is_bad_input(catalog_->add_void({kRunId, "SN1", {}, {}, {}, "bad", "", 5.0})));
  EXPECT_TRUE(is_bad_input(catalog_->add_void({kRunId, "SN2", {}, {}, {}, "bad", "bob", 5.0})));
  EXPECT_TRUE(is_bad_input(catalog_->add_void({kRunId, "SN1", 7, {}, {}, "bad", "bob", 5.0})));
  EXPECT_TRUE(is_bad_input(catalog_->add_void({kRunId, "SN1", {}, "+X", {}, "bad", "bob", 5.0})));
  EXPECT_TRUE(is_bad_input(catalog_->add_void({kRunId, "SN1", 0, {}, 0, "bad", "bob", 5.0})));
}

TEST_F(CatalogTest, RefusesAModelThatIsNotAsItWasStored) {
  fill(*catalog_);
  SQLite::Database database = raw();
  database.exec("DROP TRIGGER model_seals_change");
  database.exec("UPDATE model SET document = replace(document, '2', '3') WHERE version = 2");
  const auto changed = catalog_->model("SN1");
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().kind, base::ErrorKind::corrupt);
  EXPECT_NE(changed.error().message.find("model 2 of unit SN1"), std::string::npos) << changed.error().message;
  EXPECT_TRUE(catalog_->model("SN1", 1));
}

TEST_F(CatalogTest, NumbersModelsPerUnitAndKeepsTheOldOnes) {
  fill(*catalog_);
  const auto newest = catalog_->model("SN1");
  ASSERT_TRUE(newest && *newest);
  EXPECT_EQ((*newest)->version, 2);
  EXPECT_EQ((*newest)->document, "{\"version\": 2}");
  EXPECT_EQ((*catalog_->model("SN1", 1))->document, "{\"version\": 1}");
  EXPECT_FALSE(*catalog_->model("SN1", 3));
  EXPECT_FALSE(*catalog_->model("SN2"));
  const auto document = [](std::int32_t) { return std::string("{}"); };
  EXPECT_TRUE(is_bad_input(catalog_->add_model("SN2", 0, 0.0, document)));
  EXPECT_TRUE(is_bad_input(catalog_->add_calibration({"SN1", 9, 0.0, "blob", "", ""})));
}

TEST_F(CatalogTest, CountsEpochsAndLogsTheReason) {
  fill(*catalog_);
  EXPECT_EQ(catalog_->begin_epoch("SN1", "gyro replaced", "ann")->epoch, 1);
  EXPECT_EQ(catalog_->ensure_unit("SN1", "other")->epoch, 1);
  EXPECT_EQ((*catalog_->unit("SN1"))->type, "generic");
  EXPECT_FALSE(*catalog_->unit("SN2"));
  EXPECT_EQ(catalog_->events()->back().text, "epoch 1, by ann: gyro replaced");
  EXPECT_TRUE(is_bad_input(catalog_->begin_epoch("SN2", "x", "ann")));
  EXPECT_TRUE(is_bad_input(catalog_->begin_epoch("SN1", "", "ann")));
  EXPECT_TRUE(is_bad_input(catalog_->begin_epoch("SN1", "x", "")));
  EXPECT_TRUE(is_bad_input(catalog_->ensure_campaign("c1", "ramp")));
  EXPECT_TRUE(catalog_->ensure_campaign("c1", "soak"));
  EXPECT_EQ(*catalog_->campaigns(), std::vector<std::string>{"c1"});
  EXPECT_EQ(catalog_->units()->size(), 1U);
}

TEST_F(CatalogTest, HasALogThatOnlyGrows) {
  fill(*catalog_);
  for (const char* sql :
       {"DELETE FROM event", "UPDATE event SET text = ''", "DELETE FROM void", "UPDATE void SET reason = 'x'",
        "REPLACE INTO event SELECT * FROM event", "REPLACE INTO void SELECT * FROM void"}) {
    EXPECT_THROW(raw().exec(sql), SQLite::Exception) << sql;
  }
  const auto events = catalog_->events();
  ASSERT_GE(events->size(), 5U);
  EXPECT_EQ(events->back().text, "looks good");
  EXPECT_TRUE(base::is_uuid(raw().execAndGet("SELECT event_id FROM event").getString()));
}

TEST_F(CatalogTest, FindsEventsByKindSubjectUserAndTime) {
  for (int i = 1; i <= 6; ++i) {
    const std::string kind = i % 2 == 0 ? "even" : "odd";
    ASSERT_TRUE(catalog_->log_event({100.0 * i, kind, "SN" + std::to_string(i % 3), "", i > 3 ? "ann" : "eva"}));
  }
  const auto numbers = [&](EventFilter filter) {
    if (filter.most == 0) filter.most = 100;
    std::vector<std::int64_t> found;
    const auto events = catalog_->find_events(filter).value();
    for (const EventRow& event : events) found.push_back(event.number);
    return found;
  };
  using Numbers = std::vector<std::int64_t>;
  EXPECT_EQ(numbers({}), (Numbers{6, 5, 4, 3, 2, 1}));
  EXPECT_EQ(numbers({.kind = "even"}), (Numbers{6, 4, 2}));
  EXPECT_EQ(numbers({.subject = "SN0"}), (Numbers{6, 3}));
  EXPECT_EQ(numbers({.user = "eva"}), (Numbers{3, 2, 1}));
  EXPECT_EQ(numbers({.from_utc_s = 200.0, .to_utc_s = 500.0}), (Numbers{4, 3, 2}));
  EXPECT_EQ(numbers({.kind = "odd", .before = 5}), (Numbers{3, 1}));
  EXPECT_EQ(numbers({.most = 2}), (Numbers{6, 5}));
  EXPECT_EQ(numbers({.kind = "even' OR 1"}), Numbers{});
  EXPECT_EQ(*catalog_->event_kinds(), (std::vector<std::string>{"even", "odd"}));
  ASSERT_TRUE(catalog_->log_event({700.0, "even", "SN1", "nobody is named", ""}));
  EXPECT_EQ(*catalog_->event_users(), (std::vector<std::string>{"ann", "eva"}));
}

TEST_F(CatalogTest, ShowsRatesInDegreesPerSecond) {
  fill(*catalog_);
  const double shown = raw().execAndGet("SELECT gyro_y_mean_dps FROM segment_dps ORDER BY t_start_s").getDouble();
  const double expected = segments_of(run_row())[0].sensor[1].mean * base::kDegPerRad;
  EXPECT_NEAR(shown, expected, 1e-12 * expected);
  EXPECT_EQ(raw().execAndGet("SELECT count(*) FROM segment_dps").getInt(), 3);
  EXPECT_EQ(raw().execAndGet("SELECT count(*) FROM run_overview").getInt(), 1);
}

TEST_F(CatalogTest, RefusesAFileOfANewerVersion) {
  fill(*catalog_);
  raw().exec("PRAGMA user_version = 7");
  const auto newer = Catalog::open(folder_.path());
  ASSERT_TRUE(is_bad_input(newer));
  EXPECT_EQ(newer.error().where, (folder_ / "station.db").string());
}

TEST_F(CatalogTest, NeverChangesGapReports) {
  fill(*catalog_);
  ASSERT_TRUE(catalog_->add_gap_report({"SN1", 2, 1.71e9, "{}"}));
  EXPECT_THROW(raw().exec("UPDATE gap_report SET document = ''"), SQLite::Exception);
  EXPECT_THROW(raw().exec("DELETE FROM gap_report"), SQLite::Exception);
  EXPECT_EQ(catalog_->gap_reports("SN1")->front().document, "{}");
  EXPECT_TRUE(catalog_->gap_reports("another")->empty());
}

TEST_F(CatalogTest, RefusesAGapReportWithoutItsModel) {
  fill(*catalog_);
  EXPECT_TRUE(is_bad_input(catalog_->add_gap_report({"SN1", 77, 1.7e9, "{}"})));
}

TEST(Catalog, RefusesFilesThatAreNoCatalog) {
  const TempFolder folder;
  std::ofstream(folder / "station.db") << std::string(5000, 'x');
  EXPECT_EQ(Catalog::open(folder.path()).error().kind, base::ErrorKind::corrupt);
  std::filesystem::remove(folder / "station.db");
  SQLite::Database((folder / "station.db").string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec("CREATE TABLE t (x)");
  EXPECT_TRUE(is_bad_input(Catalog::open(folder.path())));
}

TEST(Catalog, NoticesDamageOfItsFile) {
  const TempFolder folder;
  {
    auto catalog = Catalog::open(folder.path());
    fill(*catalog);
  }
  std::string bytes = testing::bytes_of_file(folder / "station.db");
  // All pages of tables and indexes; the first eight hold the schema's text.
  for (std::size_t page = std::size_t{8} * 4096; page < bytes.size(); page += 4096)
    bytes.replace(page, 200, 200, '\x5A');
  std::ofstream(folder / "station.db", std::ios::binary | std::ios::trunc) << bytes;
  const auto catalog = Catalog::open(folder.path());
  const auto status = catalog ? catalog->verify() : base::Status(base::forward_error(catalog));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::corrupt) << status.error().message;
  EXPECT_EQ(status.error().where, (folder / "station.db").string());
}

TEST(Catalog, OpensInManyProcessesAtOnceAndNumbersModelsWithoutGap) {
  const TempFolder folder;
  constexpr int kProcesses = 4;
  constexpr int kModels = 25;
  std::vector<pid_t> children;
  for (int process = 0; process < kProcesses; ++process) {
    children.push_back(testing::in_child([&] {
      auto catalog = Catalog::open(folder.path());
      if (!catalog || !catalog->ensure_unit("SN1", "generic")) return 1;
      for (int i = 0; i < kModels; ++i) {
        const auto added = catalog->add_model(
            "SN1", 0, 1.0, [](std::int32_t version) { return "{\"version\": " + std::to_string(version) + "}"; });
        if (!added) return 2;
      }
      return 0;
    }));
  }
  for (const pid_t child : children) EXPECT_EQ(testing::status_of(child), 0);
  const auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog);
  for (int version = 1; version <= kProcesses * kModels; ++version) {
    const auto model = catalog->model("SN1", version);
    ASSERT_TRUE(model && *model) << version;
    EXPECT_EQ((*model)->document, "{\"version\": " + std::to_string(version) + "}");
  }
  EXPECT_FALSE(*catalog->model("SN1", kProcesses * kModels + 1));
  EXPECT_TRUE(catalog->verify());
}

// The numbers that a fit uses stand in the catalog: whoever or whatever changes one must not go unnoticed.
TEST_F(CatalogTest, AChangedNumberOfARunIsFound) {
  fill(*catalog_);
  ASSERT_TRUE(catalog_->check_numbers(run_row()));
  for (const char* change : {"UPDATE segment SET gyro_x_mean = gyro_x_mean + 1e-9",
                             "UPDATE segment SET plateau_c = 0 WHERE visit = 0", "UPDATE block SET accel_z_se = 1",
                             "DELETE FROM block WHERE ordinal = 1", "UPDATE run SET purpose = 'verification'",
                             "UPDATE run SET gravity_mps2 = 9.8", "UPDATE run SET numbers_sha256 = ''",
                             "INSERT INTO finding VALUES ((SELECT run_id FROM run), 'SN1', 0, (SELECT position FROM "
                             "segment WHERE visit = 0), 0, 9, "
                             "'stuck', 'reject', NULL, '')"}) {
    const TempFolder folder;
    {
      auto catalog = Catalog::open(folder.path());
      ASSERT_TRUE(catalog);
      fill(*catalog);
    }
    SQLite::Database file((folder / "station.db").string(), SQLite::OPEN_READWRITE);
    file.exec("DROP TRIGGER run_seals_change");  // calls a function that only this program has
    ASSERT_GT(file.exec(change), 0) << change;
    const auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog);
    const auto sound = catalog->check_numbers(run_row());
    ASSERT_FALSE(sound) << change;
    EXPECT_EQ(sound.error().kind, base::ErrorKind::corrupt);
    EXPECT_NE(sound.error().message.find(kRunId), std::string::npos);
    const auto segments = catalog->segments(kRunId, "SN1", false);
    ASSERT_FALSE(segments) << change;
    EXPECT_EQ(segments.error().kind, base::ErrorKind::corrupt);
  }
}

}  // namespace
}  // namespace soak::db
