// SPDX-License-Identifier: Apache-2.0
// The data gate: sensors that are stuck or at the end of their range.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/segments/data_gate.h"
#include "calib/segments/segmentation.h"
#include "tests/calib/data_gate_samples.h"

namespace soak::calib {
namespace {

using namespace gate_samples;

TEST(DataGate, FindsAStuckSensorWhoseNoiseIsBelowItsStep) {
  Recording r = still({.seconds = 15.0, .accel_noise_mps2 = 0.008, .accel_lsb_mps2 = 0.01}, 46);
  std::fill(sensor(r, Sensor::accel_y).begin() + 500, sensor(r, Sensor::accel_y).begin() + 1100, 0.1);
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "stuck");
  EXPECT_EQ(finding.severity, Severity::reject);
}

TEST(DataGate, FindsASensorThatIsFrozenInHalfOfTheSegments) {
  for (const double noise_steps : {0.5, 2.0, 20.0}) {
    const Still how{.seconds = 20.0, .gyro_noise_rps = 1e-3, .gyro_lsb_rps = 1e-3 / noise_steps};
    const auto findings = findings_of(positions_in_turn(kSix, how, [](Recording& one, std::size_t i) {
      if (i >= 3) std::fill(sensor(one, Sensor::gyro_y).begin(), sensor(one, Sensor::gyro_y).end(), 0.01);
    }));
    EXPECT_EQ(findings.size(), 3U) << noise_steps << listed(findings);
    for (const Finding& finding : findings) {
      EXPECT_EQ(finding.code, "stuck");
      EXPECT_EQ(finding.severity, Severity::reject);
    }
  }
}

TEST(DataGate, FindsAQuietCoarseAccelerometerThatIsFrozen) {
  // Noise of a tenth of a step: one number per segment is usual, the same at +g and -g is not.
  const Still how{.seconds = 20.0, .accel_noise_mps2 = 0.001, .accel_lsb_mps2 = 0.01};
  expect_clean(positions_in_turn(kSix, how, [](Recording&, std::size_t) {}));
  const auto findings = findings_of(positions_in_turn(kSix, how, [](Recording& one, std::size_t i) {
    if (i >= 3) std::fill(sensor(one, Sensor::accel_z).begin(), sensor(one, Sensor::accel_z).end(), 0.13);
  }));
  const auto stuck = std::count_if(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.code == "stuck" && finding.severity == Severity::reject && finding.sensor == Sensor::accel_z;
  });
  EXPECT_EQ(stuck, 3) << listed(findings);
}

TEST(DataGate, RejectsASensorAtTheEndOfItsRange) {
  UnitType type;
  type.accel_range_mps2 = 9.85;  // a 1 g sensor with a bias of 0.1 in a field of 1 g
  Recording r = still({}, 11);
  for (double& value : sensor(r, Sensor::accel_z)) value = std::min(value, 9.85);
  const Finding finding = only(findings_of(r, type));
  EXPECT_EQ(finding.code, "saturated");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_EQ(finding.sensor, Sensor::accel_z);
  EXPECT_NE(finding.text.find("9.85 m/s2"), std::string::npos) << finding.text;
}

TEST(DataGate, FindsSaturationWithoutKnowingTheRange) {
  Recording r = still({.accel_lsb_mps2 = 0.001}, 12);
  // Cut off one standard deviation above the mean: 16 % of the samples.
  for (double& value : sensor(r, Sensor::accel_z)) value = std::min(value, kG + 0.11);
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "saturated");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_NE(finding.text.find("9.91665"), std::string::npos) << finding.text;
}

TEST(DataGate, TakesNoNoiseThatPeaksAtItsExtremeStepForSaturation) {
  // Noise of half a step whose mean lies near one of them: most samples stand on the second highest or highest step.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    expect_clean(still({.accel_noise_mps2 = 0.005 + 0.0003 * static_cast<double>(seed), .accel_lsb_mps2 = 0.01}, seed));
  }
}

TEST(DataGate, TakesNoDriftThatEndsOnOneStepForSaturation) {
  Recording r = still({}, 13);
  // Rises through ten steps in the first half second and stays on the last, flickering to the one below now and then.
  for (std::size_t i = 0; i < r.rows(); ++i) {
    const double level = std::round(10.0 * std::min(1.0, static_cast<double>(i) / 50.0));
    sensor(r, Sensor::gyro_x)[i] = 1e-4 * (level == 10.0 && i % 12 == 0 ? 9.0 : level);
  }
  expect_clean(r);
}

TEST(DataGate, RejectsASensorThatSticksWhileItLivesElsewhere) {
  Recording r = still({.gyro_lsb_rps = 2e-4}, 14);
  std::fill(sensor(r, Sensor::gyro_y).begin() + 4000, sensor(r, Sensor::gyro_y).end(), 0.0102);
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "stuck");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_EQ(finding.sensor, Sensor::gyro_y);
  EXPECT_NE(finding.text.find("2000"), std::string::npos) << finding.text;
}

TEST(DataGate, KnowsAStuckSegmentByTheNoiseOfTheOthers) {
  Recording r = still({}, 15);
  Recording dead = still({}, 16);
  std::fill(sensor(dead, Sensor::accel_y).begin(), sensor(dead, Sensor::accel_y).end(), 0.123);
  append(r, dead);
  const auto cut = segment(r);
  ASSERT_EQ(cut->segments.size(), 2U);
  const auto findings = examine(r, cut->segments, {});
  EXPECT_TRUE(findings[0].empty()) << listed(findings[0]);
  EXPECT_EQ(only(findings[1]).code, "stuck");
}

TEST(DataGate, RejectsASensorThatGivesOneNumberThroughoutAndWarnsWhereResolutionMayExplainIt) {
  Recording r = still({}, 17);
  Recording later = still({}, 18);
  std::fill(later.plateau_c.begin(), later.plateau_c.end(), 30.0);
  for (double& temp_c : later.temp_c) temp_c += 5.0;
  std::fill(sensor(r, Sensor::accel_x).begin(), sensor(r, Sensor::accel_x).end(), 0.25);
  EXPECT_EQ(only(findings_of(r)).severity, Severity::warn);
  std::fill(sensor(later, Sensor::accel_x).begin(), sensor(later, Sensor::accel_x).end(), 0.25);
  append(r, later);
  const auto both = findings_of(r);
  ASSERT_EQ(both.size(), 2U) << listed(both);
  EXPECT_EQ(both[0].code, "stuck");
  EXPECT_EQ(both[0].severity, Severity::reject);
}

TEST(DataGate, TakesNoQuietSensorOnCoarseStepsForStuck) {
  // Noise of a tenth of a step: for seconds on end there is one number, then another.
  expect_clean(still({.gyro_noise_rps = 1e-5, .gyro_lsb_rps = 1e-4, .temp_rate_kpmin = 1.0}, 18));
}

TEST(DataGate, TakesAQuietCoarseGyroThatShowsOneNumberInAllPositionsAsItIs) {
  // Gravity does not turn a gyro; at one temperature its one code may explain the one number.
  const Still how{.seconds = 20.0, .gyro_noise_rps = 1e-4, .gyro_lsb_rps = 2e-3};
  const auto findings = findings_of(positions_in_turn(kSix, how, [](Recording&, std::size_t) {}));
  ASSERT_FALSE(findings.empty());
  for (const Finding& finding : findings) EXPECT_EQ(finding.severity, Severity::warn) << finding.text;
}

}  // namespace
}  // namespace soak::calib
