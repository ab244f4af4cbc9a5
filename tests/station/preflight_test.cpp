// SPDX-License-Identifier: Apache-2.0
#include "station/lab/run_recorder.h"
#include "station/lab/segment_capture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"
#include "base/units.h"
#include "calib/vocabulary/position.h"
#include "tests/errors.h"

namespace soak::station {
namespace {

using calib::Sensor;

constexpr double kStandardGravity_mps2 = 9.80665;
constexpr double kStatedRate_hz = 100.0;

calib::UnitType judged_type() {
  calib::UnitType type;
  type.gyro_noise_max_dps_rthz = 0.02;
  type.gyro_bias_max_dps = 1.0;
  type.accel_noise_max_mps2_rthz = 0.002;
  type.accel_bias_max_mps2 = 0.3;
  return type;
}

/// What a sound unit shows in the six positions: noise at half of its limits, biases at half of theirs.
std::vector<PreflightRecord> good_unit(const std::string& serial = "SN1") {
  std::vector<PreflightRecord> records;
  for (const std::string_view label : calib::kSixPositionLabels) {
    PreflightRecord record;
    record.unit = serial;
    record.position = label;
    record.type = judged_type();
    record.asked_rate_hz = kStatedRate_hz;
    record.rate_hz = kStatedRate_hz;
    record.samples = 2000;
    record.lost_packets = 3;
    const auto up = calib::position_named(label)->up;
    // White noise of density n, one-sided, sampled at R per second, has the standard deviation n·√(R/2).
    const double per_density = std::sqrt(kStatedRate_hz / 2.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      record.spread[axis] = {-0.5 * base::kRadPerDeg, 0.01 * base::kRadPerDeg * per_density};
      record.spread[3 + axis] = {0.15 + kStandardGravity_mps2 * up[axis], 0.001 * per_density};
    }
    records.push_back(record);
  }
  return records;
}

SampleSpread& spread_of(PreflightRecord& record, Sensor sensor) { return record.spread[calib::index_of(sensor)]; }

/// The only finding; fails where there is another number of them.
PreflightFinding only_finding(const std::vector<PreflightRecord>& records) {
  const auto findings = preflight_findings(records);
  EXPECT_EQ(findings.size(), 1U);
  return findings.empty() ? PreflightFinding{} : findings.front();
}

TEST(Preflight, AGoodUnitGivesNoFinding) { EXPECT_TRUE(preflight_findings(good_unit()).empty()); }

TEST(Preflight, AUnitThatSendsAtAnotherRateIsFound) {
  for (const double factor : {0.5, 2.0}) {
    auto records = good_unit();
    for (PreflightRecord& record : records) record.rate_hz = factor * kStatedRate_hz;
    const auto [fault, text] = only_finding(records);
    EXPECT_EQ(fault, PreflightFault::wrong_rate);
    EXPECT_TRUE(base::holds(text, "SN1") && base::holds(text, "100")) << text;
  }
}

TEST(Preflight, ARateOfTheUnitsOwnAndARecordingThatBrokeOffAreNoWrongRate) {
  auto records = good_unit();
  for (PreflightRecord& record : records) record.rate_hz = 1.26 * kStatedRate_hz;
  records.front().rate_hz = 0.1 * kStatedRate_hz;
  for (SampleSpread& spread : records.front().spread) spread.sigma *= 0.3;  // the same density
  EXPECT_TRUE(preflight_findings(records).empty());
}

TEST(Preflight, AReadingThatIsNoNumberIsFound) {
  auto records = good_unit();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  spread_of(records[2], Sensor::accel_z) = {nan, nan};
  const auto [fault, text] = only_finding(records);
  EXPECT_EQ(fault, PreflightFault::not_finite);
  EXPECT_TRUE(base::holds(text, "unit SN1, accel_z: ")) << text;
}

TEST(Preflight, ASensorWithoutASingleChangeIsStuck) {
  auto records = good_unit();
  for (PreflightRecord& record : records) spread_of(record, Sensor::gyro_y) = {0.002, 0.0};
  const auto [fault, text] = only_finding(records);
  EXPECT_EQ(fault, PreflightFault::stuck);
  EXPECT_TRUE(base::holds(text, "unit SN1, gyro_y: ")) << text;
}

TEST(Preflight, ASensorThatStoodStillInOnePositionOnlyIsNotStuck) {
  for (std::size_t position = 0; position < 6; ++position) {
    auto records = good_unit();
    spread_of(records[position], Sensor::gyro_y).sigma = 0.0;
    EXPECT_TRUE(preflight_findings(records).empty()) << position;
  }
}

TEST(Preflight, NoiseAboveTheTypesLimitIsToldWithBothFigures) {
  auto records = good_unit();
  // 0.05 deg/s/√Hz at 100 samples per second.
  spread_of(records[4], Sensor::gyro_z).sigma = 0.05 * std::sqrt(50.0) * base::kRadPerDeg;
  PreflightFinding found = only_finding(records);
  EXPECT_EQ(found.fault, PreflightFault::noise);
  EXPECT_TRUE(base::holds(found.text, "unit SN1, gyro_z: ")) << found.text;
  EXPECT_TRUE(base::holds(found.text, " 0.05 deg/s/√Hz") && base::holds(found.text, " 0.02")) << found.text;

  records = good_unit();
  spread_of(records[0], Sensor::accel_x).sigma = 0.003 * std::sqrt(50.0);
  found = only_finding(records);
  EXPECT_EQ(found.fault, PreflightFault::noise);
  EXPECT_TRUE(base::holds(found.text, "unit SN1, accel_x: ")) << found.text;
  EXPECT_TRUE(base::holds(found.text, " 0.003 m/s2/√Hz") && base::holds(found.text, " 0.002")) << found.text;
}

TEST(Preflight, NoiseDensityDoesNotDependOnTheSampleRate) {
  // The same density at ten times the rate has a standard deviation √10 times as large.
  auto records = good_unit();
  for (PreflightRecord& record : records) {
    record.rate_hz *= 10.0;
    record.asked_rate_hz = record.rate_hz;
    for (SampleSpread& spread : record.spread) spread.sigma *= std::sqrt(10.0);
  }
  EXPECT_TRUE(preflight_findings(records).empty());
  for (PreflightRecord& record : records) record.rate_hz = record.asked_rate_hz = kStatedRate_hz;
  EXPECT_EQ(preflight_findings(records).size(), calib::kSensorCount);
}

TEST(Preflight, ABiasIsToldWithoutGravity) {
  auto records = good_unit();
  for (PreflightRecord& record : records) spread_of(record, Sensor::accel_z).mean += 0.35;  // to 0.5 m/s²
  PreflightFinding found = only_finding(records);
  EXPECT_EQ(found.fault, PreflightFault::bias);
  EXPECT_TRUE(base::holds(found.text, "unit SN1, accel_z: ")) << found.text;
  EXPECT_TRUE(base::holds(found.text, " 0.5 m/s2") && base::holds(found.text, " 0.3")) << found.text;

  records = good_unit();
  for (PreflightRecord& record : records) spread_of(record, Sensor::gyro_x).mean = -1.5 * base::kRadPerDeg;
  found = only_finding(records);
  EXPECT_EQ(found.fault, PreflightFault::bias);
  EXPECT_TRUE(base::holds(found.text, "unit SN1, gyro_x: ")) << found.text;
  EXPECT_TRUE(base::holds(found.text, " -1.5 deg/s") && base::holds(found.text, " 1")) << found.text;
}

TEST(Preflight, ALimitThatTheTypeDoesNotStateIsNotJudged) {
  auto records = good_unit();
  for (PreflightRecord& record : records) {
    record.type = {};
    for (SampleSpread& spread : record.spread) {
      spread.sigma *= 1000.0;
      spread.mean += 100.0;
    }
  }
  EXPECT_TRUE(preflight_findings(records).empty());
}

TEST(Preflight, SamplesAtARailAreCountedOverThePositions) {
  auto records = good_unit();
  records[1].clipped = 2;
  records[5].clipped = 5;
  const auto [fault, text] = only_finding(records);
  EXPECT_EQ(fault, PreflightFault::clipped);
  EXPECT_TRUE(base::holds(text, "unit SN1: 7 ")) << text;
}

TEST(Preflight, LostPacketsMayBeOneInAThousand) {
  auto records = good_unit();  // 12000 samples; the loss counts since the run began
  records.back().lost_packets = 12;
  EXPECT_TRUE(preflight_findings(records).empty());
  records.back().lost_packets = 13;
  const auto [fault, text] = only_finding(records);
  EXPECT_EQ(fault, PreflightFault::lost_packets);
  EXPECT_TRUE(base::holds(text, "unit SN1: 13 ") && base::holds(text, " 12013")) << text;
}

TEST(Preflight, TooFewSamplesAreToldWithTheirPosition) {
  auto records = good_unit();
  records[3].samples = 20;
  EXPECT_TRUE(preflight_findings(records).empty());
  records[3].samples = 19;
  const auto [fault, text] = only_finding(records);
  EXPECT_EQ(fault, PreflightFault::few_samples);
  EXPECT_TRUE(base::holds(text, " 19 ") && base::holds(text, "-Y")) << text;
}

TEST(Preflight, AUnitThatGaveNothingHasAFindingForEachPosition) {
  auto records = good_unit();
  for (PreflightRecord& record : records) {
    record.samples = 0;
    record.spread = {};
  }
  const auto findings = preflight_findings(records);
  for (const std::string_view label : calib::kSixPositionLabels) {
    EXPECT_TRUE(std::any_of(findings.begin(), findings.end(), [&](const PreflightFinding& finding) {
      return finding.fault == PreflightFault::few_samples && base::holds(finding.text, std::string(label));
    })) << label;
  }
}

TEST(Preflight, EachUnitIsJudgedByItself) {
  auto records = good_unit("SN1");
  auto other = good_unit("SN2");
  spread_of(other[0], Sensor::accel_y).sigma = 1.0;
  other[0].clipped = 1;
  // In the order of time: position by position.
  for (std::size_t i = 0; i < other.size(); ++i) records.insert(records.begin() + static_cast<int>(2 * i), other[i]);
  const auto findings = preflight_findings(records);
  ASSERT_EQ(findings.size(), 2U);
  for (const PreflightFinding& finding : findings) EXPECT_TRUE(base::holds(finding.text, "unit SN2")) << finding.text;
}

TEST(Preflight, WhiteNoiseOfAKnownDensityIsMeasuredRight) {
  // The same path as in the laboratory: samples through SegmentCapture. 0.002 m/s²/√Hz is the type's limit.
  for (const double share : {0.9, 1.1}) {
    base::Random random(11);
    SegmentCapture capture(1000.0);
    for (int i = 0; i <= 20'000; ++i) {
      hal::ImuSample sample;
      sample.t_s = i / kStatedRate_hz;
      for (float& rate : sample.rate_rps) rate = static_cast<float>(1e-4 * random.gaussian());
      for (float& accel : sample.accel_mps2) {
        accel = static_cast<float>(share * 0.002 * std::sqrt(kStatedRate_hz / 2.0) * random.gaussian());
      }
      static_cast<void>(capture.takes(sample));
    }
    PreflightRecord record = good_unit().front();
    record.samples = capture.samples();
    for (const Sensor sensor : calib::kSensors) spread_of(record, sensor) = capture.spread(sensor);
    EXPECT_EQ(preflight_findings({record}).size(), share > 1.0 ? 3U : 0U) << share;
  }
}

TEST(Preflight, TheEstimateOfTheDiskCoversEveryNumberOfARow) {
  const double bytes = estimated_bytes(100.0, 2, 3600.0);
  // Six sensors and a time as four-byte numbers at least, and not several times what a row can be.
  const double rows = 100.0 * 2 * 3600.0;
  EXPECT_GE(bytes, 28.0 * rows);
  EXPECT_LE(bytes, 80.0 * rows);
  EXPECT_EQ(estimated_bytes(100.0, 0, 3600.0), 0.0);
  EXPECT_EQ(estimated_bytes(100.0, 2, 7200.0), 2.0 * bytes);
}

}  // namespace
}  // namespace soak::station
