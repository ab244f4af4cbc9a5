// SPDX-License-Identifier: Apache-2.0
// What the data gate keeps out of the search is said.
#include "calib/gap/observations/observations.h"

#include <gtest/gtest.h>

#include <functional>

#include "calib/gap/report/gap_report.h"
#include "tests/errors.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

/// A campaign without a hidden effect, with the same finding in some segments of its last run.
LoggedCampaign rejected_in_last_run(const Finding& finding, const std::function<bool(const Segment&)>& where) {
  LoggedCampaign campaign = made_up::campaign({}, made_up::nothing());
  for (Segment& segment : campaign.runs.back().run.segments) {
    if (where(segment)) segment.findings.push_back(finding);
  }
  return campaign;
}

const Finding kWrongPosition = {"wrong_position", Severity::reject, {}, "gravity points along -Z"};

TEST(GateRejection, MostOfARunLeavesNoPlainNone) {
  const GapReport report =
      find_gap(rejected_in_last_run(kWrongPosition, [](const Segment& segment) { return segment.key.visit >= 3; }), 1);
  EXPECT_EQ(name_of(report.conclusion), "cannot_judge") << report.reason;
  EXPECT_TRUE(base::mentions(report.reason, {"R6", "60", "78", "wrong_position"}));
  ASSERT_EQ(report.rejections.size(), 1U);
  EXPECT_EQ(report.rejections[0].run, "R6");
  EXPECT_FALSE(report.rejections[0].sensor);
  EXPECT_EQ(report.rejections[0].segments, 60U);
  EXPECT_EQ(report.rejections[0].of, 78U);
  EXPECT_EQ(report.rejections[0].why, "gravity points along -Z");
}

TEST(GateRejection, ASensorOfARunIsSaidBesideTheVerdict) {
  const Finding stuck = {"stuck", Severity::reject, Sensor::gyro_y, "one number repeated"};
  const GapReport report = find_gap(rejected_in_last_run(stuck, [](const Segment&) { return true; }), 1);
  EXPECT_EQ(name_of(report.conclusion), "none") << report.reason;
  EXPECT_TRUE(base::mentions(report.reason, {"gyro_y", "R6", "78", "stuck"}));
  ASSERT_EQ(report.rejections.size(), 1U);
  EXPECT_EQ(report.rejections[0].sensor, Sensor::gyro_y);
}

TEST(GateRejection, AWholeSegmentIsNotCountedForItsSensorsToo) {
  LoggedCampaign campaign =
      rejected_in_last_run(kWrongPosition, [](const Segment& segment) { return segment.key.visit == 3; });
  for (Segment& segment : campaign.runs.back().run.segments) {
    if (segment.key.visit == 3 || segment.key.visit == 4) {
      segment.findings.push_back({"stuck", Severity::reject, Sensor::accel_x, "one number repeated"});
    }
  }
  const auto rejections = rejected_by_gate(campaign);
  ASSERT_EQ(rejections.size(), 2U);
  EXPECT_EQ(rejections[0].segments, 6U);
  EXPECT_EQ(rejections[1].sensor, Sensor::accel_x);
  EXPECT_EQ(rejections[1].segments, 6U);
}

TEST(GateRejection, WarningsLeaveNothingOut) {
  const Finding warning = {"dropouts", Severity::warn, Sensor::gyro_x, "a few samples are missing"};
  const GapReport report = find_gap(rejected_in_last_run(warning, [](const Segment&) { return true; }), 1);
  EXPECT_TRUE(report.rejections.empty());
  EXPECT_FALSE(base::mentions(report.reason, {"dropouts"}));
  EXPECT_FALSE(base::mentions(report.reason, {"R6"}));
}

}  // namespace
}  // namespace soak::calib::gap
