// SPDX-License-Identifier: Apache-2.0
// The part of the rule of release that a clock decides; the rest is tested by the commands (tests/cli/test_release.py).
#include "station/release/release_rule.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calib/model/document_parts.h"
#include "station/io/text.h"
#include "tests/db/support.h"
#include "tests/errors.h"

namespace soak::station {
namespace {

double date_utc_s(const char* text) { return parse_iso_date(text).value(); }

/// A unit with a verified model that was measured with two references, one of them by a waiver.
class ReleaseRuleTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(catalog_.ensure_unit("SN1", "generic"));
    ASSERT_TRUE(catalog_.ensure_campaign("check", "verification"));
    calib::ReferenceUse waived{reference("probe 1", "2025-03-01"), calib::Waiver(), {}};
    const nlohmann::json calibration = {
        {"unit", "SN1"},
        {"unit_type", "generic"},
        {"epoch", 0},
        {"model_version", 1},
        {"created_utc_s", date_utc_s("2026-06-01")},
        {"simulated", false},
        {"gravity_mps2", 9.80665},
        {"gravity_assumed", true},
        {"run_hashes", nlohmann::json::array()},
        {"sensors", nlohmann::json::array()},
        {"references", calib::stored_references({waived, {reference("probe 2", "2098-03-01"), {}, {}}})}};
    const nlohmann::json document = {{"format", "soak-model"}, {"format_version", 1}, {"calibration", calibration}};
    ASSERT_TRUE(catalog_.add_model("SN1", 0, date_utc_s("2026-06-01"), [&](std::int32_t) { return document.dump(); }));
    ASSERT_TRUE(catalog_.add_verification({"SN1", 1, date_utc_s("2026-06-02"), "ann", "pass",
                                           R"({"campaign": "check", "limits": "unit type generic", "runs": []})"}));
    ASSERT_TRUE(catalog_.set_model_state({"SN1", 1, "verified", "passed", "ann", date_utc_s("2026-06-02")}));
  }

  static calib::Reference reference(const char* name, const char* due) {
    return {"0192f0a0-0000-7000-8000-000000000001",
            calib::ReferenceKind::chamber_probe,
            name,
            "C1",
            std::nullopt,
            0.1,
            date_utc_s("2024-03-01"),
            date_utc_s(due)};
  }

  [[nodiscard]] ReleaseCase judged_on(const char* date) const {
    const auto head = model_head(catalog_, "SN1", 1);
    EXPECT_TRUE(head);
    auto release = judge_release(catalog_, *head, date_utc_s(date));
    EXPECT_TRUE(release) << release.error().message;
    return *std::move(release);
  }

  db::testing::TempFolder folder_;
  db::Catalog catalog_ = db::Catalog::open(folder_.path()).value();
};

TEST_F(ReleaseRuleTest, AModelIsGoodUntilItsFirstReferenceWithoutAWaiverIsDue) {
  const ReleaseCase before = judged_on("2098-02-28");
  EXPECT_TRUE(before.obstacles.empty());
  EXPECT_EQ(before.expires_utc_s, date_utc_s("2098-03-01"));
  const ReleaseCase after = judged_on("2098-03-01");
  ASSERT_EQ(after.obstacles.size(), 1U);
  EXPECT_TRUE(base::mentions(after.obstacles.front(), {"probe 2", "2098-03-01", "fit again"}));
}

TEST_F(ReleaseRuleTest, TheLastVerificationCountsAndNotTheBest) {
  ASSERT_TRUE(catalog_.add_verification({"SN1", 1, date_utc_s("2026-06-03"), "ann", "marginal",
                                         R"({"campaign": "check", "limits": "unit type generic", "runs": []})"}));
  const ReleaseCase release = judged_on("2027-01-01");
  ASSERT_EQ(release.obstacles.size(), 1U);
  EXPECT_TRUE(base::mentions(release.obstacles.front(), {"check", "marginal"}));
}

TEST_F(ReleaseRuleTest, ADamagedVerificationIsNoVerdict) {
  ASSERT_TRUE(catalog_.add_verification({"SN1", 1, date_utc_s("2026-06-03"), "ann", "pass", "pass"}));
  const auto release = judge_release(catalog_, model_head(catalog_, "SN1", 1).value(), date_utc_s("2027-01-01"));
  ASSERT_FALSE(release);
  EXPECT_EQ(release.error().kind, base::ErrorKind::corrupt);
}

}  // namespace
}  // namespace soak::station
