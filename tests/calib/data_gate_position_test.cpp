// SPDX-License-Identifier: Apache-2.0
// The data gate: positions that the accelerometers contradict.
#include <gtest/gtest.h>

#include "calib/segments/data_gate.h"
#include "tests/calib/data_gate_samples.h"

namespace soak::calib {
namespace {

using namespace gate_samples;

TEST(DataGate, NamesThePositionThatAWrongLabelLooksLike) {
  Recording r = still({.position = "-Y"}, 8);
  r.positions = {*position_named("+Y")};
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "wrong_position");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_NE(finding.text.find("179 deg"), std::string::npos) << finding.text;
  EXPECT_NE(finding.text.find("-Y"), std::string::npos) << finding.text;
  // With a type whose accelerometers read -g on the axis that points up, the label is right.
  UnitType type;
  type.sign_at_rest = -1;
  expect_clean(r, type);
}

TEST(DataGate, ToleratesAFixtureThatIsNotTrue) {
  Recording r = still({}, 9);
  tilt(r, 0, r.rows(), 15.0);
  expect_clean(r);
  tilt(r, 0, r.rows(), 10.0);  // 25 degrees: no other position is nearer
  EXPECT_EQ(only(findings_of(r)).code, "wrong_position");
  EXPECT_EQ(only(findings_of(r)).severity, Severity::warn);
  tilt(r, 0, r.rows(), 25.0);
  EXPECT_EQ(only(findings_of(r)).severity, Severity::reject);
}

TEST(DataGate, TakesALargeBiasForNoWrongLabel) {
  const Still how{.seconds = 20.0};
  for (const Vector3& bias : {Vector3{3.0, -3.0, 2.0}, Vector3{2.5, 2.5, 0.0}}) {
    const auto add_bias = [&](Recording& r, std::size_t) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (double& value : r.sensor[3 + axis]) value += bias[axis];
      }
    };
    expect_clean(positions_in_turn(kSix, how, add_bias));
    // One position alone does not tell the bias; -Z is nearest all the same.
    for (const Finding& finding : findings_of(positions_in_turn({"-Z"}, how, add_bias))) {
      EXPECT_EQ(finding.code, "wrong_position");
      EXPECT_EQ(finding.severity, Severity::warn) << finding.text;
    }
  }
}

TEST(DataGate, FindsTwoSwappedLabelsUnderALargeBias) {
  Recording r = positions_in_turn(kSix, {.seconds = 20.0}, [](Recording& one, std::size_t) {
    for (double& value : sensor(one, Sensor::accel_x)) value += 3.0;
  });
  std::swap(r.positions[0], r.positions[3]);  // +X and -Y
  const auto findings = findings_of(r);
  ASSERT_EQ(findings.size(), 2U) << listed(findings);
  for (const Finding& finding : findings) EXPECT_EQ(finding.severity, Severity::reject) << finding.text;
  EXPECT_NE(findings[0].text.find("+X"), std::string::npos) << findings[0].text;
  EXPECT_NE(findings[1].text.find("-Y"), std::string::npos) << findings[1].text;
}

TEST(DataGate, NamesTheRemedyOnceWhereAUnitReadsMinusGUp) {
  const Recording r = positions_in_turn(kSix, {.seconds = 20.0}, [](Recording& one, std::size_t) {
    for (std::size_t s = 3; s < 6; ++s) {
      for (double& value : one.sensor[s]) value = -value;
    }
  });
  const auto findings = findings_of(r);
  ASSERT_EQ(findings.size(), 6U) << listed(findings);
  int named = 0;
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.severity, Severity::reject);
    named += finding.text.find("sign_at_rest = -1") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(named, 1) << listed(findings);
  EXPECT_NE(findings[0].text.find("scale = -1"), std::string::npos) << findings[0].text;
  UnitType type;
  type.sign_at_rest = -1;
  expect_clean(r, type);
}

TEST(DataGate, JudgesAPositionByTheAccelerometersThatWereRecorded) {
  Recording r = still({.position = "-Z"}, 10);
  r.positions = {*position_named("+Z")};
  sensor(r, Sensor::accel_x).clear();
  sensor(r, Sensor::accel_y).clear();
  EXPECT_EQ(only(findings_of(r)).code, "wrong_position");
  Recording blind = r;
  sensor(blind, Sensor::accel_x) = sensor(r, Sensor::gyro_x);
  sensor(blind, Sensor::accel_z).clear();
  expect_clean(blind);
}

}  // namespace
}  // namespace soak::calib
