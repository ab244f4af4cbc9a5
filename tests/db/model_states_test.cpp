// SPDX-License-Identifier: Apache-2.0
// What becomes of a model: states with their history, verifications, and catalogs of version 2, which knew neither.
#include <SQLiteCpp/Database.h>

#include "tests/db/sample_catalog.h"

namespace soak::db {
namespace {

using testing::fill;
using testing::TempFolder;

class ModelStates : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = Catalog::open(folder_.path());
    ASSERT_TRUE(opened) << opened.error().message;
    catalog_.emplace(std::move(*opened));
    fill(*catalog_);
  }

  base::Status to(const char* state, std::int32_t version = 2) {
    return catalog_->set_model_state({"SN1", version, state, "as asked", "ann", 1700000600.0});
  }
  std::string state_of(std::int32_t version) { return catalog_->models("SN1")->at(version - 1U).state; }

  TempFolder folder_;
  std::optional<Catalog> catalog_;
};

TEST_F(ModelStates, GoOneWayAndEndInWithdrawn) {
  EXPECT_EQ(state_of(2), "fitted");
  EXPECT_FALSE(to("released"));
  EXPECT_FALSE(to("fitted"));
  ASSERT_TRUE(to("verified"));
  ASSERT_TRUE(to("fitted"));
  EXPECT_FALSE(to("released"));
  ASSERT_TRUE(to("verified"));
  ASSERT_TRUE(to("released"));
  EXPECT_FALSE(to("verified"));
  EXPECT_EQ(state_of(2), "released");
  ASSERT_TRUE(to("released")) << "anew, after a verification that failed";
  EXPECT_EQ(state_of(1), "fitted");
  ASSERT_TRUE(to("withdrawn"));
  for (const char* state : {"fitted", "verified", "released", "withdrawn"}) {
    const auto refused = to(state);
    ASSERT_FALSE(refused) << state;
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
    EXPECT_NE(refused.error().message.find("model 2 of unit SN1 is withdrawn"), std::string::npos);
  }
}

TEST_F(ModelStates, KeepTheirHistoryWithUserAndReason) {
  ASSERT_TRUE(to("verified"));
  ASSERT_TRUE(catalog_->set_model_state({"SN1", 2, "withdrawn", "gyro broke", "bob", 1700000700.0}));
  const auto history = catalog_->model_history("SN1", 2);
  ASSERT_TRUE(history) << history.error().message;
  ASSERT_EQ(history->size(), 3U);
  EXPECT_EQ((*history)[0].state, "fitted");
  EXPECT_EQ((*history)[0].utc_s, 1700000300.0);
  EXPECT_EQ((*history)[1].state, "verified");
  EXPECT_EQ((*history)[2].reason, "gyro broke");
  EXPECT_EQ((*history)[2].user, "bob");
  EXPECT_EQ(catalog_->events()->back().kind, "model_withdrawn");
  EXPECT_EQ(catalog_->events()->back().user, "bob");
  SQLite::Database database((folder_ / "station.db").string(), SQLite::OPEN_READWRITE);
  for (const char* sql : {"DELETE FROM model_state", "UPDATE model_state SET user = 'x'"}) {
    EXPECT_THROW(database.exec(sql), SQLite::Exception) << sql;
  }
  EXPECT_TRUE(catalog_->verify());
}

TEST_F(ModelStates, RefuseWhatNamesNobodyAndNoModel) {
  for (const ModelStateRow& row : {ModelStateRow{"SN1", 2, "verified", "", "ann", 1.0},
                                   {"SN1", 2, "verified", "r", "", 1.0},
                                   {"SN1", 9, "verified", "r", "ann", 1.0},
                                   {"SN9", 1, "verified", "r", "ann", 1.0}}) {
    const auto refused = catalog_->set_model_state(row);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  }
  EXPECT_FALSE(catalog_->add_verification({"SN1", 9, 1.0, "ann", "pass", "{}"}));
  EXPECT_EQ(catalog_->events()->back().text, "looks good");
}

TEST_F(ModelStates, GiveVerificationsInTheirOrder) {
  ASSERT_TRUE(catalog_->add_verification({"SN1", 2, 1700000600.0, "ann", "fail", "{\"a\": 1}"}));
  ASSERT_TRUE(catalog_->add_verification({"SN1", 2, 1700000700.0, "bob", "pass", "{\"a\": 2}"}));
  const auto stored = catalog_->verifications("SN1", 2);
  ASSERT_TRUE(stored) << stored.error().message;
  ASSERT_EQ(stored->size(), 2U);
  EXPECT_EQ((*stored)[0].verdict, "fail");
  EXPECT_EQ((*stored)[1].document, "{\"a\": 2}");
  EXPECT_EQ((*stored)[1].user, "bob");
  EXPECT_TRUE(catalog_->verifications("SN1", 1)->empty());
  EXPECT_TRUE(catalog_->verify());
}

TEST_F(ModelStates, AreSealed) {
  ASSERT_TRUE(to("verified"));
  SQLite::Database database((folder_ / "station.db").string(), SQLite::OPEN_READWRITE);
  database.exec("DROP TRIGGER model_state_keeps_rows; DROP TRIGGER model_state_seals_change");
  database.exec("UPDATE model_state SET user = 'carol'");
  EXPECT_EQ(catalog_->verify().error().kind, base::ErrorKind::corrupt);
}

TEST_F(ModelStates, SayWhereAModelCameFrom) {
  catalog_->act_as("eva");
  const std::string inputs(64, 'd');
  ASSERT_TRUE(catalog_->add_model(
      "SN1", 0, 1700000800.0, [](std::int32_t) { return std::string("{}"); }, ModelOrigin{"0.9.1", inputs}));
  const auto origin = catalog_->model_origin("SN1", 3);
  ASSERT_TRUE(origin && *origin);
  EXPECT_EQ((*origin)->software, "0.9.1");
  EXPECT_EQ((*origin)->inputs_sha256, inputs);
  EXPECT_EQ((*origin)->user, "eva");
  EXPECT_EQ(catalog_->model_history("SN1", 3)->front().user, "eva");
  EXPECT_FALSE(*catalog_->model_origin("SN1", 2));
}

/// data/v2/station.db is data/v1/station.db as version 2 of the programs brought it forward.
TEST(Version2, ModelsAreFittedAndCanBecomeMore) {
  const TempFolder folder;
  std::filesystem::copy_file(std::filesystem::path(SOAK_TEST_FOLDER) / "db" / "data" / "v2" / "station.db",
                             folder / "station.db");
  auto catalog = Catalog::open(folder.path());
  ASSERT_TRUE(catalog) << catalog.error().message;
  const auto models = catalog->models();
  ASSERT_TRUE(models) << models.error().message;
  ASSERT_EQ(models->size(), 2U);
  for (const ModelHead& model : *models) EXPECT_EQ(model.state, "fitted");
  EXPECT_EQ(catalog->model_history("SN1", 1)->front().user, "");
  EXPECT_TRUE(catalog->set_model_state({"SN1", 2, "verified", "passed", "ann", 1700000600.0}));
  EXPECT_TRUE(catalog->add_verification({"SN1", 2, 1700000600.0, "ann", "pass", "{}"}));
  EXPECT_TRUE(catalog->verify());
}

}  // namespace
}  // namespace soak::db
