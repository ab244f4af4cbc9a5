// SPDX-License-Identifier: Apache-2.0
#include "station/records/check_standard.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/calib/six_position_samples.h"
#include "tests/db/support.h"

namespace soak::station {
namespace {

using calib::ControlVerdict;

/// A catalog in which unit CS is measured with a bias of its gyros of its own in each campaign.
class CheckStandard : public ::testing::Test {
 protected:
  void measure(const std::string& campaign, double gyro_bias, const std::string& unit = "CS",
               const std::string& purpose = "calibration") {
    calib::test::Bench bench;
    bench.plateaus_c = {25, 0, 50, 25};
    bench.gyro_bias = [gyro_bias](double) { return gyro_bias; };
    bench.gyro_noise = bench.accel_noise = 1e-6;
    bench.seed = ++number_;
    auto segments = calib::test::segments_of(bench);
    db::RunRow run;
    run.run_id = "00000000-0000-7000-8000-" + std::to_string(100000000000 + number_);
    run.unit = unit;
    run.campaign = campaign;
    run.label = "R" + std::to_string(number_);
    run.procedure = "soak";
    run.purpose = purpose;
    run.created_utc_s = static_cast<double>(number_);
    run.sealed = true;
    run.file_name = run.run_id + ".soakrun";
    run.file_sha256 = run.content_sha256 = std::string(64, 'a');
    run.site = calib::test::standard_site();
    for (calib::Segment& segment : segments) {
      segment.key.run_id = run.run_id;
      segment.key.unit = unit;
    }
    ASSERT_TRUE(catalog_.ensure_unit(unit, "generic"));
    ASSERT_TRUE(catalog_.ensure_campaign(campaign, "soak"));
    const auto added = catalog_.add_run(run, segments);
    ASSERT_TRUE(added) << added.error().message;
  }

  /// Twelve campaigns c1... in control: their biases alternate about 0.1 rad/s.
  void measure_twelve() {
    for (int i = 1; i <= 12; ++i) measure("c" + std::to_string(i), 0.1 + (i % 2 == 0 ? 0.001 : -0.001));
  }

  std::string declare(const std::string& unit = "CS") {
    return catalog_.add_check_standard({.unit = unit, .since_utc_s = 1e6, .reason = "test", .user = "me"}).value();
  }

  std::vector<CheckVerdict> verdicts(const std::string& campaign) {
    return check_standard_of(catalog_, campaign).value();
  }

  std::uint64_t number_ = 0;
  db::testing::TempFolder folder_;
  db::Catalog catalog_ = db::Catalog::open(folder_.path()).value();
};

TEST_F(CheckStandard, NobodyJudgesACampaignWithoutOne) {
  measure_twelve();
  EXPECT_TRUE(verdicts("c12").empty());
  declare();
  EXPECT_TRUE(verdicts("nowhere").empty());
  measure("other", 0.5, "SN2");
  EXPECT_TRUE(verdicts("other").empty());
}

TEST_F(CheckStandard, EachCampaignHasTheVerdictOfItsTime) {
  measure_twelve();
  declare();
  EXPECT_EQ(verdicts("c10").at(0).verdict, ControlVerdict::not_established);
  EXPECT_EQ(verdicts("c11").at(0).verdict, ControlVerdict::in_control);
  measure("bad", 0.2);
  measure("c14", 0.1);
  const CheckVerdict bad = verdicts("bad").at(0);
  EXPECT_EQ(bad.unit, "CS");
  EXPECT_EQ(bad.campaign, "bad");
  EXPECT_EQ(bad.verdict, ControlVerdict::out_of_control);
  EXPECT_EQ(bad.findings.size(), 3u);  // the three gyros; accelerometers read as before
  EXPECT_EQ(verdicts("c14").at(0).verdict, ControlVerdict::in_control);
}

TEST_F(CheckStandard, OnlyOneThatIsOutOfControlWarnsAndWithItsNumbers) {
  measure_twelve();
  declare();
  EXPECT_FALSE(warning_of(verdicts("c1").at(0)));
  EXPECT_FALSE(warning_of(verdicts("c12").at(0)));
  measure("bad", 0.2);
  const auto warning = warning_of(verdicts("bad").at(0));
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->code, "check_standard_out_of_control");
  // 0.2 rad/s is 11.459 deg/s.
  for (const char* part : {"CS", "'bad'", "gyro_x reads 11.459 deg/s, outside", "12 campaigns before"}) {
    EXPECT_NE(warning->text.find(part), std::string::npos) << part << "\n" << warning->text;
  }
}

TEST_F(CheckStandard, TwoOfThemBothSpeak) {
  measure("c", 0.1);
  measure("c", 0.1, "CS2");
  declare();
  declare("CS2");
  ASSERT_EQ(verdicts("c").size(), 2u);
  EXPECT_EQ(verdicts("c")[0].unit, "CS");
  EXPECT_EQ(verdicts("c")[1].unit, "CS2");
}

TEST_F(CheckStandard, AfterItsEndItJudgesWhatWasBeforeAndNothingAfter) {
  measure_twelve();
  const std::string id = declare();
  ASSERT_TRUE(catalog_.end_check_standard(id, {.reason = "dropped", .user = "me", .utc_s = 12.5}));
  measure("after", 0.2);
  EXPECT_EQ(verdicts("c12").at(0).verdict, ControlVerdict::in_control);
  EXPECT_TRUE(verdicts("after").empty());
  // Declared again: another chart.
  declare();
  EXPECT_EQ(verdicts("after").at(0).verdict, ControlVerdict::not_established);
  EXPECT_TRUE(verdicts("c12").empty());
}

TEST_F(CheckStandard, VerificationAndVoidRunsAreNotOnTheChart) {
  measure_twelve();
  declare();
  measure("v", 0.2, "CS", "verification");
  EXPECT_TRUE(verdicts("v").empty());
  measure("bad", 0.2);
  db::VoidRecord record;
  record.run_id = catalog_.runs({.unit = {}, .campaign = "bad", .run = {}})->at(0).run_id;
  record.unit = "CS";
  record.reason = "door was open";
  record.user = "me";
  ASSERT_TRUE(catalog_.add_void(record));
  EXPECT_TRUE(verdicts("bad").empty());
}

}  // namespace
}  // namespace soak::station
