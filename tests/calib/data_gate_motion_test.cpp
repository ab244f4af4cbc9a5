// SPDX-License-Identifier: Apache-2.0
// The data gate: units that moved, turned or were knocked.
#include <gtest/gtest.h>

#include "base/units.h"
#include "calib/segments/data_gate.h"
#include "tests/calib/data_gate_samples.h"

namespace soak::calib {
namespace {

using namespace gate_samples;

TEST(DataGate, FindsASmallTiltInMidSegment) {
  Recording r = still({}, 1);
  tilt(r, 3000, r.rows(), 0.5);
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "moved");
  EXPECT_EQ(finding.severity, Severity::reject);
  EXPECT_FALSE(finding.sensor);
  EXPECT_NE(finding.text.find("by 0.5"), std::string::npos) << finding.text;
}

TEST(DataGate, FindsAUnitThatIsLiftedAndPutBack) {
  Recording r = still({}, 2);
  tilt(r, 2000, 3000, 30.0);
  EXPECT_EQ(only(findings_of(r)).code, "moved");
}

TEST(DataGate, FindsATurnAboutTheVerticalByTheGyroAlone) {
  Recording r = still({}, 3);
  // 5 degrees in 2 s; gravity sees nothing of it.
  for (std::size_t i = 2500; i < 2700; ++i) sensor(r, Sensor::gyro_z)[i] += 2.5 * base::kRadPerDeg;
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "moved");
  EXPECT_NE(finding.text.find("gyro_z"), std::string::npos) << finding.text;
}

TEST(DataGate, TakesNoSlowThermalDriftForMotion) {
  Still how;
  how.seconds = 600.0;
  how.rate_hz = 10.0;
  how.temp_rate_kpmin = 3.0;    // 30 K in all, as on a ramp
  how.bias_per_k_mps2 = 7e-3;   // 0.21 m/s²: 1.2° of apparent tilt on each horizontal axis
  how.bias_per_k_rps = 1.7e-3;  // 0.1 deg/s per kelvin: 3 deg/s in all
  expect_clean(still(how, 4));
}

TEST(DataGate, TakesNoSmallTiltWithinNoiseForMotion) {
  Recording r = still({}, 5);
  tilt(r, 3000, r.rows(), 0.1);
  expect_clean(r);
}

TEST(DataGate, RejectsAKnockThatShiftsTheMeansAndWarnsOfOneThatDoesNot) {
  for (const double size_mps2 : {1.0, 10.0}) {
    Recording r = still({}, 6);
    for (std::size_t i = 1000; i < 1003; ++i) {
      for (const Sensor s : {Sensor::accel_x, Sensor::accel_y}) sensor(r, s)[i] += size_mps2;
    }
    const Finding finding = only(findings_of(r));
    EXPECT_EQ(finding.code, "knocked");
    // Three samples among 6000 of noise 0.01: 3 · size / (0.01 · √6000) standard errors, 3.9 and 39.
    EXPECT_EQ(finding.severity, Severity::reject) << finding.text;
    EXPECT_NE(finding.text.find("1 "), std::string::npos) << finding.text;
  }
  Recording r = still({}, 6);
  for (const Sensor s : {Sensor::accel_x, Sensor::accel_y}) sensor(r, s)[1000] += 1.0;  // 1.3 standard errors
  EXPECT_EQ(only(findings_of(r)).severity, Severity::warn);
}

/// Lone samples are marked, sensor by sensor, and nothing else is found.
void expect_spikes(const Recording& r, const std::vector<Sensor>& sensors) {
  const auto findings = findings_of(r);
  ASSERT_EQ(findings.size(), sensors.size()) << listed(findings);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    EXPECT_EQ(findings[i].code, "spike");
    EXPECT_EQ(findings[i].severity, Severity::warn);
    EXPECT_EQ(findings[i].sensor, sensors[i]);
  }
}

TEST(DataGate, TakesNoOutlierOfOneSensorForAKnock) {
  Recording r = still({}, 7);
  sensor(r, Sensor::gyro_y)[1000] += 1.0;
  sensor(r, Sensor::accel_y)[4000] += 1.0;
  expect_spikes(r, {Sensor::gyro_y, Sensor::accel_y});
}

TEST(DataGate, WarnsOfASteadyTurnAboutTheVertical) {
  const auto findings = findings_of(positions_in_turn(kSix, {.seconds = 20.0}, [](Recording& one, std::size_t i) {
    if (i != 4) return;
    for (double& value : sensor(one, Sensor::gyro_z)) value += 0.8 * base::kRadPerDeg;
  }));
  const Finding finding = only(findings);
  EXPECT_EQ(finding.code, "moved");
  EXPECT_EQ(finding.severity, Severity::warn);
  EXPECT_NE(finding.text.find("0.80 deg/s"), std::string::npos) << finding.text;
}

TEST(DataGate, TakesABadSampleOrAKnockForNoMotion) {
  const Still how{.rate_hz = 50.0};
  Recording gyro = still(how, 40);
  sensor(gyro, Sensor::gyro_x)[1500] = 200.0 * base::kRadPerDeg;
  expect_spikes(gyro, {Sensor::gyro_x});
  Recording accel = still(how, 41);
  sensor(accel, Sensor::accel_x)[1500] = 150.0;
  expect_spikes(accel, {Sensor::accel_x});
  Recording knock = still(how, 42);
  for (std::size_t i = 1500; i < 1510; ++i) {
    for (const Sensor s : kSensors) sensor(knock, s)[i] += i % 2 == 0 ? 20.0 : -15.0;
  }
  EXPECT_EQ(only(findings_of(knock)).code, "knocked");
}

/// 80 K in 80 minutes in one attitude, without plateaus; accelerometers drift by 1.2 mg/K, and not in a straight line.
Recording ramp(double curvature) {
  Still how;
  how.seconds = 4800.0;
  how.rate_hz = 5.0;
  how.temp_rate_kpmin = 1.0;
  how.bias_per_k_mps2 = 1.2e-3 * kG;
  Recording r = still(how, 43);
  for (std::size_t i = 0; i < r.rows(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(r.rows());
    for (std::size_t s = 3; s < 6; ++s) r.sensor[s][i] += curvature * kG * share * share;
  }
  return r;
}

TEST(DataGate, TakesAPoorUnitOnALongRampForUnmoved) {
  expect_clean(ramp(0.0));
  expect_clean(ramp(0.02));
}

// Recorded by a station: down, up and back. Memory of the way made "moved" of units that nobody had touched.
TEST(DataGate, TakesAMemoryOfTheWayOnARampForUnmoved) {
  Recording r = ramp(0.0);
  r.plateau_c.clear();
  const std::size_t turn = r.rows() / 2;
  for (std::size_t i = turn; i < r.rows(); ++i) {
    const std::size_t there = 2 * turn - 1 - std::min(i, 2 * turn - 1);
    r.temp_c[i] = r.temp_c[there];
    for (std::size_t s = 3; s < 6; ++s) r.sensor[s][i] = r.sensor[s][there];
  }
  for (std::size_t i = 0; i < r.rows(); ++i) {
    // After the turn the other branch is reached within some 10 K.
    const double way_c = i < turn ? 0.0 : std::abs(r.temp_c[i] - r.temp_c[turn]);
    sensor(r, Sensor::accel_x)[i] += 0.08 * -std::expm1(-way_c / 10.0);
    sensor(r, Sensor::accel_y)[i] -= 0.08 * -std::expm1(-way_c / 10.0);
  }
  expect_clean(r);
}

TEST(DataGate, FindsAMoveOnALongRamp) {
  for (const double share : {0.2, 0.5, 0.8}) {
    Recording r = ramp(0.0);
    tilt(r, static_cast<std::size_t>(share * static_cast<double>(r.rows())), r.rows(), 1.0);
    EXPECT_EQ(only(findings_of(r)).code, "moved") << share;
  }
}

TEST(DataGate, FindsMotionWithoutAllThreeAccelerometers) {
  for (const bool with_x : {false, true}) {
    Recording r = still({}, 44);
    tilt(r, 3000, r.rows(), 60.0);
    sensor(r, Sensor::accel_y).clear();
    if (!with_x) sensor(r, Sensor::accel_x).clear();
    const auto found = findings_of(r);  // and a warning of the mean direction where two of them see it
    ASSERT_FALSE(found.empty()) << with_x;
    EXPECT_EQ(found.front().code, "moved") << with_x;
    Recording rest = still({}, 45);
    sensor(rest, Sensor::accel_y).clear();
    if (!with_x) sensor(rest, Sensor::accel_x).clear();
    expect_clean(rest);
  }
}

TEST(DataGate, TakesACodeOfACoarseGyroForNoTurn) {
  // One code is 0.5 deg/s, 5 degrees in ten seconds.
  Recording r = still({.gyro_noise_rps = 1e-4}, 47);
  for (std::size_t i = 0; i < r.rows(); ++i) {
    sensor(r, Sensor::gyro_z)[i] = (i < 2200 || i >= 3300 ? 0.5 : 1.0) * base::kRadPerDeg;
  }
  expect_clean(r);
}

}  // namespace
}  // namespace soak::calib
