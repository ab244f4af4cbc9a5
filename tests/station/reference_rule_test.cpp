// SPDX-License-Identifier: Apache-2.0
#include "station/fit/reference_rule.h"

#include <SQLiteCpp/Database.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <memory>

#include "station/io/text.h"
#include "station/records/reference_register.h"
#include "station/records/signing.h"
#include "tests/errors.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;
using calib::ReferenceKind;

constexpr double kDay_s = 86400.0;

double day(const char* text) { return parse_iso_date(text).value(); }

class ReferenceRule : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-rule-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
    auto opened = db::Catalog::open(folder);
    ASSERT_TRUE(opened) << opened.error().message;
    catalog = std::make_unique<db::Catalog>(*std::move(opened));
  }
  void TearDown() override { fs::remove_all(folder); }

  calib::Reference add(ReferenceKind kind, const std::string& name, const std::string& certificate, const char* issued,
                       const char* due) {
    db::ReferenceRow row;
    row.reference = {"", kind, name, certificate, std::nullopt, 0.1, day(issued), day(due)};
    row.user = "ann";
    row.entered_utc_s = row.reference.issued_utc_s;
    row.reference.record_id = catalog->add_reference(row).value();
    return row.reference;
  }

  calib::Waiver waive(const calib::Reference& reference, const std::string& id, const std::string& reason = "ordered") {
    const auto waiver =
        signed_waiver({id, reference.record_id, reason, "Ann", "", 1.75e9, ""}, reference, SecretKey({1, 2, 3}));
    EXPECT_TRUE(waiver);
    EXPECT_TRUE(catalog->add_waiver(*waiver));
    return *waiver;
  }

  [[nodiscard]] base::Result<JudgedReferences> judge(const char* begin, double days = 1.0) const {
    return judge_references(*catalog, {day(begin), day(begin) + days * kDay_s});
  }

  /// Certificates of the references for a measurement that begins that day.
  [[nodiscard]] std::vector<std::string> certificates(const char* begin) const {
    std::vector<std::string> found;
    const JudgedReferences judged = judge(begin).value();
    for (const calib::ReferenceUse& use : judged.uses) found.push_back(use.reference.certificate);
    return found;
  }

  fs::path folder;
  std::unique_ptr<db::Catalog> catalog;
};

using Texts = std::vector<std::string>;

TEST_F(ReferenceRule, AnEmptyRegisterBlocksNothingAndIsNoted) {
  const auto judged = judge("2026-11-22");
  ASSERT_TRUE(judged);
  EXPECT_TRUE(judged->uses.empty());
  ASSERT_EQ(judged->notes.size(), 1U);
  EXPECT_TRUE(base::holds(judged->notes[0], "'soak reference add'"));
}

TEST_F(ReferenceRule, TakesTheCertificateThatWasTheNewestOnThatDay) {
  add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2026-01-01");
  add(ReferenceKind::chamber_probe, "probe 3", "C", "2026-06-01", "2027-06-01");
  add(ReferenceKind::chamber_probe, "probe 3", "B", "2025-12-01", "2026-12-01");  // entered late
  add(ReferenceKind::chamber_probe, "probe 4", "D", "2025-01-01", "2035-01-01");
  add(ReferenceKind::level, "probe 3", "E", "2025-01-01", "2035-01-01");
  EXPECT_EQ(certificates("2026-11-22"), (Texts{"C", "D", "E"}));
  EXPECT_EQ(certificates("2026-06-01"), (Texts{"C", "D", "E"})) << "from the day of the issue on";
  EXPECT_EQ(certificates("2026-05-31"), (Texts{"B", "D", "E"}));
  EXPECT_EQ(certificates("2025-11-30"), (Texts{"A", "D", "E"}));
}

TEST_F(ReferenceRule, OfTwoEntriesOfOneDayTheLaterCorrectsTheEarlier) {
  add(ReferenceKind::supply, "meter", "typo", "2026-01-01", "2027-01-01");
  add(ReferenceKind::supply, "meter", "right", "2026-01-01", "2027-01-01");
  EXPECT_EQ(certificates("2026-11-22"), Texts{"right"});
}

TEST_F(ReferenceRule, ARetiredReferenceDoesNotComeBackWithAnOlderCertificate) {
  const auto older = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2030-01-01");
  const auto newer = add(ReferenceKind::chamber_probe, "probe 3", "B", "2026-01-01", "2031-01-01");
  ASSERT_TRUE(catalog->retire_reference(newer.record_id, {"dropped", "ann", 1.0}));
  EXPECT_TRUE(certificates("2026-11-22").empty());
  EXPECT_TRUE(certificates("2025-11-22").empty());
  add(ReferenceKind::chamber_probe, "probe 3", "repaired", "2026-02-01", "2031-01-01");
  EXPECT_EQ(certificates("2026-11-22"), Texts{"repaired"});
}

TEST_F(ReferenceRule, ARetiredReferenceCountsForWhatWasMeasuredBeforeAndIsNoted) {
  const auto probe = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2030-01-01");
  ASSERT_TRUE(catalog->retire_reference(probe.record_id, {"dropped", "ann", day("2026-05-01")}));
  EXPECT_EQ(certificates("2026-04-30"), Texts{"A"});
  EXPECT_TRUE(certificates("2026-05-01").empty());
  const auto judged = judge("2026-04-01");
  ASSERT_EQ(judged->notes.size(), 1U);
  EXPECT_TRUE(base::mentions(judged->notes[0], {"2026-05-01", "ann", "dropped"}));
  EXPECT_TRUE(judge("2026-06-01")->notes.empty());
}

TEST_F(ReferenceRule, AnEntryAfterTheRetirementBringsTheReferenceBackWhateverItsDayOfIssue) {
  const auto probe = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-06-01", "2030-01-01");
  ASSERT_TRUE(catalog->retire_reference(probe.record_id, {"lost", "ann", day("2026-05-01")}));
  db::ReferenceRow again{probe, "ann", day("2026-07-01")};
  again.reference.certificate = "older";
  again.reference.issued_utc_s = day("2025-01-01");
  ASSERT_TRUE(catalog->add_reference(again));
  EXPECT_EQ(certificates("2026-08-01"), Texts{"older"});
  EXPECT_EQ(certificates("2026-04-01"), Texts{"A"}) << "what counted then";
  again = {probe, "ann", day("2026-07-02")};
  ASSERT_TRUE(catalog->add_reference(again)) << "word for word";
  EXPECT_EQ(certificates("2026-08-01"), Texts{"A"});
}

TEST_F(ReferenceRule, AWithdrawnEntryCountsAsNeverMade) {
  add(ReferenceKind::level, "level 1", "right", "2026-01-11", "2027-01-11");
  const auto mistyped = add(ReferenceKind::level, "level 1", "typo", "2026-11-01", "2026-11-02");
  EXPECT_FALSE(judge("2026-11-22")) << "the entry with the later day of issue stands for it";
  ASSERT_TRUE(catalog->withdraw_reference(mistyped.record_id, {"mistyped", "ann", day("2026-11-20")}));
  EXPECT_EQ(certificates("2026-11-22"), Texts{"right"});
  EXPECT_EQ(certificates("2026-11-01"), Texts{"right"});
}

TEST_F(ReferenceRule, ACampaignWithAWithdrawnEntryTakesTheOneThatCorrectsIt) {
  const auto wrong = add(ReferenceKind::level, "level 1", "L-7", "2026-01-01", "2027-01-01");
  ASSERT_TRUE(catalog->ensure_campaign("c1", "soak"));
  ASSERT_TRUE(catalog->add_campaign_references("c1", {{wrong, std::nullopt}}));
  ASSERT_TRUE(catalog->withdraw_reference(wrong.record_id, {"u mistyped", "ann", day("2026-02-01")}));
  const auto kept = references_of_campaigns(*catalog, {"c1"});
  ASSERT_EQ(kept->size(), 1U);
  EXPECT_EQ(kept->at(0).reference.record_id, wrong.record_id);
  const auto warnings = reference_warnings(*catalog, *kept);
  ASSERT_EQ(warnings->size(), 1U);
  EXPECT_EQ(warnings->at(0).code, "reference_withdrawn");
  EXPECT_TRUE(base::mentions(warnings->at(0).text, {"2026-02-01", "ann", "u mistyped"}));

  db::ReferenceRow corrected{wrong, "ann", day("2026-02-01")};
  corrected.reference.standard_uncertainty = 0.01;
  ASSERT_TRUE(catalog->add_reference(corrected));
  const auto healed = references_of_campaigns(*catalog, {"c1"});
  ASSERT_EQ(healed->size(), 1U);
  EXPECT_EQ(healed->at(0).reference.standard_uncertainty, 0.01);
  EXPECT_TRUE(reference_warnings(*catalog, *healed)->empty());
}

TEST_F(ReferenceRule, AReferenceThatWasRetiredSinceIsToldOfAndKept) {
  const auto probe = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2030-01-01");
  ASSERT_TRUE(catalog->ensure_campaign("c1", "soak"));
  ASSERT_TRUE(catalog->add_campaign_references("c1", {{probe, std::nullopt}}));
  EXPECT_TRUE(reference_warnings(*catalog, *references_of_campaigns(*catalog, {"c1"}))->empty());
  ASSERT_TRUE(catalog->retire_reference(probe.record_id, {"dropped", "ann", day("2026-05-01")}));
  const auto uses = references_of_campaigns(*catalog, {"c1"});
  ASSERT_EQ(uses->size(), 1U);
  const auto warnings = reference_warnings(*catalog, *uses);
  ASSERT_EQ(warnings->size(), 1U);
  EXPECT_EQ(warnings->at(0).code, "reference_retired");
  EXPECT_TRUE(base::holds(warnings->at(0).text, "'probe 3'") && base::holds(warnings->at(0).text, "dropped"));
}

TEST_F(ReferenceRule, AUseSaysInWhichOfTheCampaignsItWas) {
  const auto spring = add(ReferenceKind::rate, "table", "A", "2025-01-01", "2030-01-01");
  const auto autumn = add(ReferenceKind::rate, "table", "B", "2025-07-01", "2030-01-01");
  const auto level = add(ReferenceKind::level, "level 1", "L", "2025-01-01", "2030-01-01");
  for (const char* campaign : {"c1", "c2", "c3"}) ASSERT_TRUE(catalog->ensure_campaign(campaign, "soak"));
  ASSERT_TRUE(catalog->add_campaign_references("c1", {{spring, std::nullopt}, {level, std::nullopt}}));
  ASSERT_TRUE(catalog->add_campaign_references("c2", {{autumn, std::nullopt}, {level, std::nullopt}}));
  const auto uses = references_of_campaigns(*catalog, {"c1", "c2", "c2", "c3"});
  ASSERT_EQ(uses->size(), 3U);
  for (const calib::ReferenceUse& use : *uses) {
    const bool both = use.reference.kind == ReferenceKind::level;
    const std::vector<std::string> one = {use.reference.certificate == "A" ? "c1" : "c2"};
    EXPECT_EQ(use.campaigns, both ? (std::vector<std::string>{"c1", "c2"}) : one);
  }
}

TEST_F(ReferenceRule, ANewWaiverHealsTheNoteOfACampaignWhoseWaiverIsDamagedOrGone) {
  const auto probe = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2026-01-01");
  const auto waiver = waive(probe, "01890a5d-ac96-774b-bcce-0000000000a1");
  ASSERT_TRUE(catalog->ensure_campaign("c1", "soak"));
  ASSERT_TRUE(catalog->add_campaign_references("c1", {{probe, waiver}}));
  SQLite::Database raw((folder / "station.db").string(), SQLite::OPEN_READWRITE);
  for (const char* trigger : {"waiver_keeps_rows", "waiver_keeps_all", "waiver_seals_change", "waiver_seals_loss"}) {
    raw.exec(std::string("DROP TRIGGER ") + trigger);
  }
  raw.exec("UPDATE waiver SET reason = 'because'");
  EXPECT_EQ(references_of_campaigns(*catalog, {"c1"}).error().kind, base::ErrorKind::corrupt);
  waive(probe, "01890a5d-ac96-774b-bcce-0000000000a2", "signed again");
  EXPECT_EQ(references_of_campaigns(*catalog, {"c1"})->at(0).waiver->reason, "signed again");
  raw.exec("DELETE FROM waiver");
  const auto gone = references_of_campaigns(*catalog, {"c1"});
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().kind, base::ErrorKind::corrupt);
  waive(probe, "01890a5d-ac96-774b-bcce-0000000000a3", "and again");
  EXPECT_EQ(references_of_campaigns(*catalog, {"c1"})->at(0).waiver->reason, "and again");
}

TEST(WaiverWarnings, NameEachWaiverWhoseSignatureDoesNotFit) {
  const calib::Reference reference{"018cc251-f400-7c3e-8000-0000000000c2",
                                   ReferenceKind::level,
                                   "level 1",
                                   "L",
                                   {},
                                   0.1,
                                   day("2025-01-01"),
                                   day("2026-01-01")};
  const calib::Waiver good =
      signed_waiver({"01890a5d-ac96-774b-bcce-0000000000a1", reference.record_id, "ordered", "Ann", "", 1.75e9, ""},
                    reference, SecretKey({1, 2, 3}))
          .value();
  calib::Waiver bad = good;
  bad.reason = "because";
  EXPECT_TRUE(waiver_warnings({{reference, good}, {reference, std::nullopt}}).empty());
  const auto warnings = waiver_warnings({{reference, good}, {reference, bad}});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].code, "waiver_signature");
  EXPECT_TRUE(base::holds(warnings[0].text, "Ann") && base::holds(warnings[0].text, "'level 1'"));
}

TEST(DaysUntil, CountTheCalendarOfUtc) {
  struct Case {
    const char* today;
    double hours;
    int days;
  };
  // Due on 2027-03-01: from the beginning of that day it has expired.
  for (const auto& [today, hours, days] :
       {Case{"2027-02-27", 0.0, 2}, Case{"2027-02-28", 0.0, 1}, Case{"2027-02-28", 12.0, 1},
        Case{"2027-02-28", 23.99, 1}, Case{"2027-03-01", 0.0, 0}, Case{"2027-03-01", 23.99, 0},
        Case{"2027-03-02", 0.0, -1}, Case{"2027-03-02", 12.0, -1}, Case{"2027-03-31", 1.0, -30},
        Case{"2026-03-01", 5.0, 365}}) {
    EXPECT_EQ(days_until(day("2027-03-01"), day(today) + 3600.0 * hours), days) << today << " " << hours;
  }
}

TEST_F(ReferenceRule, OnesThatWereNotCalibratedYetAreLeftOutAndNoted) {
  add(ReferenceKind::chamber_probe, "probe 3", "A", "2026-06-01", "2027-06-01");
  const auto judged = judge("2026-05-01");
  ASSERT_TRUE(judged);
  EXPECT_TRUE(judged->uses.empty());
  ASSERT_EQ(judged->notes.size(), 1U);
  EXPECT_TRUE(base::holds(judged->notes[0], "'probe 3'") && base::holds(judged->notes[0], "2026-05-01"));
}

TEST_F(ReferenceRule, OneThatHasExpiredBlocksFromTheDueDayOnAndTheRemediesAreNamed) {
  add(ReferenceKind::chamber_probe, "probe 3", "D-K-15048", "2025-01-01", "2026-01-01");
  add(ReferenceKind::level, "level 1", "L-7", "2025-01-01", "2026-01-01");
  add(ReferenceKind::supply, "meter", "M-1", "2025-01-01", "2036-01-01");
  EXPECT_TRUE(judge("2025-12-30"));
  const auto blocked = judge("2026-01-01");
  ASSERT_FALSE(blocked);
  EXPECT_EQ(blocked.error().kind, base::ErrorKind::bad_input);
  for (const char* part : {"chamber_probe 'probe 3'", "D-K-15048", "level 'level 1'", "2026-01-01",
                           "soak reference add", "soak reference waive --kind chamber_probe --name \"probe 3\""}) {
    EXPECT_TRUE(base::holds(blocked.error().message, part)) << part << "\n" << blocked.error().message;
  }
  EXPECT_FALSE(base::holds(blocked.error().message, "M-1"));
}

TEST_F(ReferenceRule, OneThatExpiresBeforeTheEndIsNotedAndUsed) {
  add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2026-01-01");
  EXPECT_TRUE(judge("2025-12-30", 1.9)->notes.empty());
  const auto judged = judge("2025-12-30", 2.1);
  ASSERT_TRUE(judged);
  EXPECT_EQ(judged->uses.size(), 1U);
  ASSERT_EQ(judged->notes.size(), 1U);
  EXPECT_TRUE(base::mentions(judged->notes[0], {"probe 3", "2026-01-01"}));
}

TEST_F(ReferenceRule, AWaiverLetsAnExpiredOneBeUsedAndStandsBesideIt) {
  const auto probe = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2026-01-01");
  waive(probe, "01890a5d-ac96-774b-bcce-0000000000a1", "first");
  waive(probe, "01890a5d-ac96-774b-bcce-0000000000a2", "second");
  const auto judged = judge("2026-11-22");
  ASSERT_TRUE(judged) << judged.error().message;
  ASSERT_EQ(judged->uses.size(), 1U);
  ASSERT_TRUE(judged->uses[0].waiver);
  EXPECT_EQ(judged->uses[0].waiver->reason, "second");
  ASSERT_EQ(judged->notes.size(), 1U);
  EXPECT_TRUE(base::holds(judged->notes[0], "Ann") && base::holds(judged->notes[0], "second"));
  EXPECT_FALSE(judge("2025-06-01")->uses[0].waiver) << "it was good then";
}

TEST_F(ReferenceRule, AWaiverIsForOneCertificateOnly) {
  const auto older = add(ReferenceKind::chamber_probe, "probe 3", "A", "2024-01-01", "2025-01-01");
  add(ReferenceKind::chamber_probe, "probe 3", "B", "2025-01-01", "2026-01-01");
  waive(older, "01890a5d-ac96-774b-bcce-0000000000a1");
  EXPECT_FALSE(judge("2026-11-22"));
}

TEST_F(ReferenceRule, ADamagedWaiverIsRefusedWhereItIsUsed) {
  const auto probe = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2026-01-01");
  auto waiver = waive(probe, "01890a5d-ac96-774b-bcce-0000000000a1");
  ASSERT_TRUE(check_waiver(waiver, probe));
  waiver.waiver_id.back() = '2';
  ASSERT_TRUE(catalog->add_waiver(waiver)) << "somebody wrote it into the database";
  const auto refused = judge("2026-11-22");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::corrupt);
  EXPECT_TRUE(judge("2025-06-01")) << "it is not used";
  waive(probe, "01890a5d-ac96-774b-bcce-0000000000a3");
  EXPECT_TRUE(judge("2026-11-22")) << "a new one takes its place";
}

TEST_F(ReferenceRule, EveryPartOfAWaiverIsSigned) {
  const auto probe = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2026-01-01");
  const auto good = waive(probe, "01890a5d-ac96-774b-bcce-0000000000a1");
  const auto bad = [&](auto change) {
    calib::Waiver waiver = good;
    calib::Reference reference = probe;
    change(waiver, reference);
    const auto checked = check_waiver(waiver, reference);
    return !checked && checked.error().kind == base::ErrorKind::corrupt;
  };
  EXPECT_FALSE(bad([](auto&, auto&) {}));
  EXPECT_TRUE(bad([](auto& waiver, auto&) { waiver.reason += "."; }));
  EXPECT_TRUE(bad([](auto& waiver, auto&) { waiver.signer = "Bob"; }));
  EXPECT_TRUE(bad([](auto& waiver, auto&) { waiver.utc_s += 1.0; }));
  EXPECT_TRUE(bad([](auto& waiver, auto&) { waiver.waiver_id[0] = '1'; }));
  EXPECT_TRUE(bad([](auto& waiver, auto&) { waiver.record_id[0] = '1'; }));
  EXPECT_TRUE(bad([](auto& waiver, auto&) { waiver.public_key_hex[0] ^= 1; }));
  EXPECT_TRUE(bad([](auto& waiver, auto&) { waiver.signature_hex[0] ^= 1; }));
  EXPECT_TRUE(bad([](auto& waiver, auto&) { waiver.signature_hex.clear(); }));
  EXPECT_TRUE(bad([](auto&, auto& reference) { reference.certificate = "B"; }));
  EXPECT_TRUE(bad([](auto&, auto& reference) { reference.due_utc_s += kDay_s; }));
  EXPECT_TRUE(bad([](auto&, auto& reference) { reference.name = "probe 4"; }));
}

TEST_F(ReferenceRule, CampaignsTogetherGiveEachEntryOnceWithItsWaiver) {
  const auto probe = add(ReferenceKind::chamber_probe, "probe 3", "A", "2025-01-01", "2026-01-01");
  const auto level = add(ReferenceKind::level, "level 1", "L", "2025-01-01", "2030-01-01");
  const auto waiver = waive(probe, "01890a5d-ac96-774b-bcce-0000000000a1");
  for (const char* campaign : {"c1", "c2", "c3"}) ASSERT_TRUE(catalog->ensure_campaign(campaign, "soak"));
  ASSERT_TRUE(catalog->add_campaign_references("c1", {{probe, std::nullopt}, {level, std::nullopt}}));
  ASSERT_TRUE(catalog->add_campaign_references("c2", {{probe, waiver}}));
  const auto both = references_of_campaigns(*catalog, {"c2", "c1", "c2", "c3"});
  ASSERT_TRUE(both) << both.error().message;
  ASSERT_EQ(both->size(), 2U);
  EXPECT_EQ((*both)[0].reference.certificate, "A");
  EXPECT_TRUE((*both)[0].waiver);
  EXPECT_FALSE((*both)[1].waiver);
  EXPECT_FALSE(references_of_campaigns(*catalog, {"c1"})->at(0).waiver);
  EXPECT_TRUE(references_of_campaigns(*catalog, {"c3"})->empty());
}

TEST(IsoDate, ReadsDaysAndNothingElse) {
  EXPECT_EQ(parse_iso_date("1970-01-01"), 0.0);
  EXPECT_EQ(parse_iso_date("2000-03-01"), 951868800.0);  // date -u -d 2000-03-01 +%s
  EXPECT_EQ(parse_iso_date("2024-02-29"), 1709164800.0);
  for (const char* text : {"", "2023-02-29", "2026-13-01", "2026-00-10", "2026-1-1", "2026-01-01 ", "01.02.2026",
                           "1969-12-31", "2026-01-1x", "+026-01-01", "2026-01--1"}) {
    EXPECT_FALSE(parse_iso_date(text)) << text;
  }
}

TEST(IsoDate, WritesTheDayOfATime) {
  EXPECT_EQ(iso_date(951868800.0), "2000-03-01");
  EXPECT_EQ(iso_date(951868799.9), "2000-02-29");
  EXPECT_EQ(iso_date(1e300), "1e+300");
  EXPECT_EQ(iso_date(-1.0), "-1");
}

}  // namespace
}  // namespace soak::station
