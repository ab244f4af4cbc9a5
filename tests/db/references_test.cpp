// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>

#include <cmath>
#include <memory>

#include "tests/db/sample_records.h"

namespace soak::db {
namespace {

using testing::cube_row;
using testing::expect_equal;
using testing::probe_row;
using testing::TempFolder;
using testing::waiver_of;

template <class T>
bool is_bad_input(const T& result) {
  return !result && result.error().kind == base::ErrorKind::bad_input;
}

class Register : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = Catalog::open(folder_.path());
    ASSERT_TRUE(opened) << opened.error().message;
    catalog_ = std::make_unique<Catalog>(*std::move(opened));
    ASSERT_TRUE(catalog_->ensure_campaign("c1", "soak"));
    ASSERT_TRUE(catalog_->ensure_campaign("c2", "soak"));
    ASSERT_TRUE(catalog_->ensure_unit("SN1", "generic"));
  }

  [[nodiscard]] std::string added(const ReferenceRow& row) const { return catalog_->add_reference(row).value(); }

  /// The entry as the register has it.
  [[nodiscard]] calib::ReferenceUse use(std::size_t entry, std::optional<calib::Waiver> waiver = {}) const {
    return {catalog_->references()->at(entry).reference, std::move(waiver)};
  }

  TempFolder folder_;
  std::unique_ptr<Catalog> catalog_;
};

TEST_F(Register, GivesBackEveryEntryInTheOrderOfEntry) {
  const std::string first = added(probe_row());
  const std::string second = added(cube_row());
  const std::string third = added(probe_row("D-K-15999", 1.73e9));
  const auto rows = catalog_->references();
  ASSERT_EQ(rows->size(), 3U);
  expect_equal((*rows)[0].reference, probe_row().reference);
  expect_equal((*rows)[1].reference, cube_row().reference);
  EXPECT_EQ((*rows)[0].reference.record_id, first);
  EXPECT_EQ((*rows)[1].reference.record_id, second);
  EXPECT_EQ((*rows)[2].reference.record_id, third);
  EXPECT_EQ((*rows)[2].reference.certificate, "D-K-15999");
  EXPECT_EQ((*rows)[0].user, "ann");
  EXPECT_EQ((*rows)[0].entered_utc_s, probe_row().entered_utc_s);
  EXPECT_FALSE((*rows)[0].retired);
  EXPECT_EQ(catalog_->events()->back().text, "chamber_probe probe 3, certificate D-K-15999, by ann");
}

TEST_F(Register, RefusesEntriesThatSayNothingOrNonsense) {
  const auto refused = [&](auto change) {
    ReferenceRow row = probe_row();
    change(row);
    return is_bad_input(catalog_->add_reference(row));
  };
  EXPECT_TRUE(refused([](ReferenceRow& row) { row.reference.name.clear(); }));
  EXPECT_TRUE(refused([](ReferenceRow& row) { row.reference.certificate.clear(); }));
  EXPECT_TRUE(refused([](ReferenceRow& row) { row.user.clear(); }));
  EXPECT_TRUE(refused([](ReferenceRow& row) { row.reference.standard_uncertainty = -1e-9; }));
  EXPECT_TRUE(refused([](ReferenceRow& row) { row.reference.standard_uncertainty = NAN; }));
  EXPECT_TRUE(refused([](ReferenceRow& row) { row.reference.correction = INFINITY; }));
  EXPECT_TRUE(refused([](ReferenceRow& row) { row.reference.due_utc_s = row.reference.issued_utc_s; }));
  EXPECT_TRUE(refused([](ReferenceRow& row) { row.reference.due_utc_s = NAN; }));
  EXPECT_TRUE(catalog_->references()->empty());
  ASSERT_TRUE(catalog_->add_reference(probe_row()));
  EXPECT_TRUE(refused([](ReferenceRow&) {})) << "word for word";
  EXPECT_FALSE(refused([](ReferenceRow& row) { row.reference.correction = 0.02; })) << "a correction of a mistake";
  EXPECT_FALSE(refused([](ReferenceRow& row) { row.reference.correction.reset(); }));
}

TEST_F(Register, RetiresAnEntryOnceWithReasonAndUser) {
  const std::string id = added(probe_row());
  EXPECT_TRUE(is_bad_input(catalog_->retire_reference(id, {"", "ann", 1.0})));
  EXPECT_TRUE(is_bad_input(catalog_->retire_reference(id, {"dropped", "", 1.0})));
  EXPECT_TRUE(is_bad_input(catalog_->retire_reference("nobody", {"dropped", "ann", 1.0})));
  ASSERT_TRUE(catalog_->retire_reference(id, {"dropped", "bob", 1.75e9}));
  EXPECT_TRUE(is_bad_input(catalog_->retire_reference(id, {"dropped", "ann", 1.0})));
  const auto row = catalog_->references()->front();
  ASSERT_TRUE(row.retired);
  EXPECT_EQ(row.retired->reason, "dropped");
  EXPECT_EQ(row.retired->user, "bob");
  EXPECT_EQ(row.retired->utc_s, 1.75e9);
}

TEST_F(Register, WithdrawsAWrongEntryOnceAndItCanBeEnteredAgain) {
  const std::string id = added(probe_row());
  EXPECT_TRUE(is_bad_input(catalog_->withdraw_reference(id, {"", "ann", 1.0})));
  EXPECT_TRUE(is_bad_input(catalog_->withdraw_reference("nobody", {"mistyped", "ann", 1.0})));
  ASSERT_TRUE(catalog_->withdraw_reference(id, {"mistyped", "bob", 1.75e9}));
  EXPECT_TRUE(is_bad_input(catalog_->withdraw_reference(id, {"mistyped", "ann", 1.0})));
  EXPECT_EQ(catalog_->events()->back().kind, "reference_withdrawn");
  static_cast<void>(added(probe_row()));
  const auto rows = catalog_->references();
  ASSERT_EQ(rows->size(), 2U);
  ASSERT_TRUE((*rows)[0].withdrawn);
  EXPECT_EQ((*rows)[0].withdrawn->reason, "mistyped");
  EXPECT_EQ((*rows)[0].withdrawn->user, "bob");
  EXPECT_EQ((*rows)[0].withdrawn->utc_s, 1.75e9);
  EXPECT_FALSE((*rows)[0].retired);
  EXPECT_FALSE((*rows)[1].withdrawn);
}

TEST_F(Register, ARetiredEntryCanBeEnteredAgainWordForWord) {
  ASSERT_TRUE(catalog_->retire_reference(added(probe_row()), {"dropped", "ann", 1.75e9}));
  static_cast<void>(added(probe_row()));
  EXPECT_TRUE(is_bad_input(catalog_->add_reference(probe_row()))) << "but not twice";
}

TEST_F(Register, OfAWaiverThatIsGoneTheNumberIsLeft) {
  const std::string probe = added(probe_row());
  ASSERT_TRUE(catalog_->add_waiver(waiver_of(probe)));
  ASSERT_TRUE(catalog_->add_campaign_references("c1", {use(0, waiver_of(probe))}));
  SQLite::Database raw((folder_ / "station.db").string(), SQLite::OPEN_READWRITE);
  for (const char* trigger : {"waiver_keeps_all", "waiver_seals_loss"})
    raw.exec(std::string("DROP TRIGGER ") + trigger);
  raw.exec("DELETE FROM waiver");
  const auto uses = catalog_->campaign_references("c1");
  ASSERT_TRUE(uses) << uses.error().message;
  ASSERT_TRUE(uses->at(0).waiver);
  EXPECT_EQ(uses->at(0).waiver->waiver_id, waiver_of(probe).waiver_id);
  EXPECT_EQ(uses->at(0).waiver->record_id, probe);
  EXPECT_EQ(uses->at(0).waiver->signature_hex, "");
}

TEST_F(Register, StoresAWaiverAsItWasSigned) {
  EXPECT_TRUE(is_bad_input(catalog_->add_waiver(waiver_of("nobody"))));
  const std::string id = added(probe_row());
  ASSERT_TRUE(catalog_->add_waiver(waiver_of(id)));
  ASSERT_EQ(catalog_->waivers()->size(), 1U);
  expect_equal(catalog_->waivers()->front(), waiver_of(id));
  EXPECT_EQ(catalog_->events()->back().text, "chamber_probe probe 3, by Ann Example: laboratory is booked out");
}

TEST_F(Register, ACampaignKeepsWhatItWasMeasuredWith) {
  const std::string probe = added(probe_row());
  const std::string cube = added(cube_row());
  ASSERT_TRUE(catalog_->add_waiver(waiver_of(cube)));
  ASSERT_TRUE(catalog_->add_campaign_references("c1", {use(1, waiver_of(cube)), use(0)}));
  ASSERT_TRUE(catalog_->add_campaign_references("c2", {use(0)}));
  // A later certificate and the end of the old one change nothing of what was noted.
  static_cast<void>(added(probe_row("D-K-15999", 1.73e9)));
  ASSERT_TRUE(catalog_->retire_reference(probe, {"dropped", "ann", 1.8e9}));
  const auto uses = catalog_->campaign_references("c1");
  ASSERT_TRUE(uses) << uses.error().message;
  ASSERT_EQ(uses->size(), 2U);
  EXPECT_EQ((*uses)[0].reference.record_id, cube);
  expect_equal((*uses)[0].reference, cube_row().reference);
  ASSERT_TRUE((*uses)[0].waiver);
  expect_equal(*(*uses)[0].waiver, waiver_of(cube));
  EXPECT_EQ((*uses)[1].reference.certificate, "D-K-15048");
  EXPECT_FALSE((*uses)[1].waiver);
  EXPECT_TRUE(catalog_->campaign_references("nobody")->empty());
  EXPECT_EQ(*catalog_->campaigns_of_reference(probe), (std::vector<std::string>{"c1", "c2"}));
  EXPECT_EQ(*catalog_->campaigns_of_reference(cube), std::vector<std::string>{"c1"});
}

TEST_F(Register, AnEntryIsNotedOnceAndALaterWaiverIsAddedToIt) {
  const std::string probe = added(probe_row());
  const auto waiver = waiver_of(probe);
  ASSERT_TRUE(catalog_->add_waiver(waiver));
  for (int again = 0; again < 2; ++again) ASSERT_TRUE(catalog_->add_campaign_references("c1", {use(0)}));
  EXPECT_FALSE(catalog_->campaign_references("c1")->front().waiver);
  for (int again = 0; again < 2; ++again) ASSERT_TRUE(catalog_->add_campaign_references("c1", {use(0, waiver)}));
  ASSERT_TRUE(catalog_->add_campaign_references("c1", {use(0)})) << "does not take the waiver away";
  const auto uses = catalog_->campaign_references("c1");
  ASSERT_EQ(uses->size(), 1U);
  EXPECT_TRUE(uses->front().waiver);
  SQLite::Database raw((folder_ / "station.db").string());
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM campaign_reference").getInt(), 2);
}

TEST_F(Register, RefusesANoteOfAnUnknownEntryOrCampaign) {
  static_cast<void>(added(probe_row()));
  calib::ReferenceUse unknown = use(0);
  unknown.reference.record_id = "nobody";
  EXPECT_TRUE(is_bad_input(catalog_->add_campaign_references("c1", {use(0), unknown})));
  EXPECT_TRUE(catalog_->campaign_references("c1")->empty()) << "all or nothing";
  EXPECT_FALSE(catalog_->add_campaign_references("nobody", {use(0)}));
}

TEST_F(Register, CheckStandardsBeginAndEnd) {
  CheckStandardRow row{.unit = "SN1", .since_utc_s = 1.7e9, .reason = "the most stable", .user = "ann"};
  CheckStandardRow bad = row;
  bad.unit = "SN2";
  EXPECT_TRUE(is_bad_input(catalog_->add_check_standard(bad)));
  bad = row;
  bad.reason.clear();
  EXPECT_TRUE(is_bad_input(catalog_->add_check_standard(bad)));
  const auto id = catalog_->add_check_standard(row);
  ASSERT_TRUE(id) << id.error().message;
  EXPECT_TRUE(is_bad_input(catalog_->add_check_standard(row))) << "it is one";
  EXPECT_TRUE(is_bad_input(catalog_->end_check_standard(*id, {"", "ann", 1.0})));
  EXPECT_TRUE(is_bad_input(catalog_->end_check_standard("nobody", {"broken", "ann", 1.0})));
  ASSERT_TRUE(catalog_->end_check_standard(*id, {"broken", "bob", 1.71e9}));
  EXPECT_TRUE(is_bad_input(catalog_->end_check_standard(*id, {"broken", "bob", 1.71e9})));
  row.since_utc_s = 1.72e9;
  ASSERT_TRUE(catalog_->add_check_standard(row)) << "once more";
  const auto rows = catalog_->check_standards();
  ASSERT_EQ(rows->size(), 2U);
  EXPECT_EQ((*rows)[0].check_standard_id, *id);
  EXPECT_EQ((*rows)[0].unit, "SN1");
  EXPECT_EQ((*rows)[0].since_utc_s, 1.7e9);
  EXPECT_EQ((*rows)[0].reason, "the most stable");
  EXPECT_EQ((*rows)[0].user, "ann");
  ASSERT_TRUE((*rows)[0].ended);
  EXPECT_EQ((*rows)[0].ended->reason, "broken");
  EXPECT_EQ((*rows)[0].ended->user, "bob");
  EXPECT_EQ((*rows)[0].ended->utc_s, 1.71e9);
  EXPECT_FALSE((*rows)[1].ended);
}

TEST_F(Register, NoRowOfTheRecordsCanBeChangedOrTakenAway) {
  const std::string probe = added(probe_row());
  ASSERT_TRUE(catalog_->add_waiver(waiver_of(probe)));
  ASSERT_TRUE(catalog_->add_campaign_references("c1", {use(0)}));
  ASSERT_TRUE(catalog_->retire_reference(probe, {"dropped", "ann", 1.8e9}));
  ASSERT_TRUE(catalog_->withdraw_reference(probe, {"mistyped", "ann", 1.8e9}));
  const auto id =
      catalog_->add_check_standard({.unit = "SN1", .since_utc_s = 1.7e9, .reason = "stable", .user = "ann"});
  ASSERT_TRUE(catalog_->end_check_standard(*id, {"broken", "bob", 1.71e9}));
  SQLite::Database raw((folder_ / "station.db").string(), SQLite::OPEN_READWRITE);
  for (const std::string table : {"reference", "reference_retirement", "reference_withdrawal", "waiver",
                                  "campaign_reference", "check_standard", "check_standard_end"}) {
    ASSERT_EQ(raw.execAndGet("SELECT count(*) FROM " + table).getInt(), 1) << table;
    const bool has_time = table == "check_standard";
    const std::string column = table == "reference" ? "due_utc_s" : has_time ? "since_utc_s" : "utc_s";
    EXPECT_THROW(raw.exec("UPDATE " + table + " SET " + column + " = " + column + " + 1"), SQLite::Exception) << table;
    EXPECT_THROW(raw.exec("DELETE FROM " + table), SQLite::Exception) << table;
    EXPECT_THROW(raw.exec("REPLACE INTO " + table + " SELECT * FROM " + table), SQLite::Exception) << table;
  }
}

}  // namespace
}  // namespace soak::db
