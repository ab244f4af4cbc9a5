// SPDX-License-Identifier: Apache-2.0
// The data gate: what it leaves alone, its findings as a whole, recordings of others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/random.h"
#include "calib/estimate/unit_input.h"
#include "tests/calib/data_gate_samples.h"
#include "tests/errors.h"

namespace soak::calib {
namespace {

using namespace gate_samples;

void remove_rows(Recording& r, std::size_t first, std::size_t last) {
  const auto cut = [&](auto& v) {
    v.erase(v.begin() + static_cast<std::ptrdiff_t>(first), v.begin() + static_cast<std::ptrdiff_t>(last));
  };
  cut(r.t_s);
  cut(r.temp_c);
  cut(r.plateau_c);
  cut(r.position);
  for (auto& values : r.sensor) cut(values);
}

TEST(DataGate, FindsNothingInThousandCleanSegments) {
  base::Random random(5);
  int findings = 0;
  std::string text;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Still how;
    how.rate_hz = std::exp(random.uniform(std::log(1.0), std::log(100.0)));
    how.seconds = random.uniform(30.0, 90.0);
    how.position = kSixPositionLabels[seed % 6];
    how.gyro_noise_rps = std::exp(random.uniform(std::log(1e-5), std::log(5e-3)));
    how.accel_noise_mps2 = std::exp(random.uniform(std::log(1e-3), std::log(5e-2)));
    // From a hundredth of the noise up to three times it.
    how.gyro_lsb_rps = how.gyro_noise_rps * std::exp(random.uniform(std::log(0.01), std::log(3.0)));
    how.accel_lsb_mps2 = how.accel_noise_mps2 * std::exp(random.uniform(std::log(0.01), std::log(3.0)));
    how.slow_share = random.uniform(0.0, 1.0);
    how.temp_rate_kpmin = random.uniform(-0.3, 0.3);
    how.temp_lsb_c = seed % 2 == 0 ? 0.0 : random.uniform(0.003, 0.3);
    const auto found = findings_of(still(how, seed));
    findings += static_cast<int>(found.size());
    text += found.empty() ? "" : std::to_string(seed) + ": " + listed(found);
  }
  EXPECT_EQ(findings, 0) << text;
}

TEST(DataGate, TakesASimulationWithoutNoiseAsItIs) {
  Recording r = still({.gyro_noise_rps = 0.0, .accel_noise_mps2 = 0.0, .temp_rate_kpmin = 0.0}, 19);
  Recording other = still({.gyro_noise_rps = 0.0, .accel_noise_mps2 = 0.0, .temp_rate_kpmin = 0.0}, 20);
  for (auto& values : other.sensor) {
    for (double& value : values) value += 0.001;
  }
  append(r, other);
  expect_clean(r);
}

TEST(DataGate, TakesADeviceThatRepeatsItsValuesAsItIs) {
  // A sensor of 20 Hz in packets of 100 Hz.
  Recording r = still({}, 21);
  for (auto& values : r.sensor) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = values[i - i % 5];
  }
  expect_clean(r);
}

TEST(DataGate, MarksAFlippedBitAndDoesNotRejectForIt) {
  for (const Sensor sensor : {Sensor::gyro_y, Sensor::accel_x}) {
    Recording r = still({}, 31);
    r.sensor[index_of(sensor)][1234] = 1e9;  // far beyond any range
    const Finding finding = only(findings_of(r));
    EXPECT_EQ(finding.code, "spike");
    EXPECT_EQ(finding.severity, Severity::warn);
    EXPECT_EQ(finding.sensor, sensor);
    const auto segments = segment(r)->segments;
    EXPECT_EQ(segments.front().sensor[index_of(sensor)].count, r.rows() - 1);
  }
}

TEST(DataGate, WarnsOfDropoutsAndRejectsWhereMuchIsMissing) {
  Recording r = still({}, 22);
  remove_rows(r, 1000, 1300);  // 3 s of 60: 5 %
  const auto found = findings_of(r);
  ASSERT_EQ(found.size(), 6U) << listed(found);
  EXPECT_EQ(found.front().code, "dropouts");
  EXPECT_EQ(found.front().severity, Severity::warn);
  EXPECT_NE(found.front().text.find("5.0 %"), std::string::npos) << found.front().text;

  Recording holes = still({}, 23);
  for (std::size_t i = 0; i < holes.rows(); i += 3) sensor(holes, Sensor::gyro_x)[i] = kNone;
  const Finding third = only(findings_of(holes));
  EXPECT_EQ(third.code, "dropouts");
  EXPECT_EQ(third.severity, Severity::reject);
  EXPECT_EQ(third.sensor, Sensor::gyro_x);
}

TEST(DataGate, TakesASlowerChannelAndASingleLostPacketAsTheyAre) {
  Recording r = still({}, 24);
  for (std::size_t i = 0; i < r.rows(); ++i) {
    if (i % 4 != 0) sensor(r, Sensor::accel_x)[i] = kNone;  // 25 Hz beside 100 Hz
  }
  remove_rows(r, 3001, 3002);
  // Gravity has no direction in rows without the x axis, but means of stretches do.
  expect_clean(r);
}

TEST(DataGate, WarnsOfIrregularSampling) {
  Recording r = still({}, 25);
  for (std::size_t i = 0; i < r.rows(); ++i) {
    r.t_s[i] = 0.04 * static_cast<double>(i / 4) + 0.001 * static_cast<double>(i % 4);  // in bursts of four
  }
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "irregular_sampling");
  EXPECT_EQ(finding.severity, Severity::warn);

  Recording jitter = still({}, 26);
  base::Random random(27);
  for (double& t_s : jitter.t_s) t_s += random.uniform(-0.002, 0.002);  // a fifth of the interval
  expect_clean(jitter);
}

TEST(DataGate, WarnsOfAThermometerInWholeDegrees) {
  Still how;
  how.temp_rate_kpmin = 5.0;
  how.temp_noise_c = 0.05;
  how.temp_lsb_c = 1.0;
  const Finding finding = only(findings_of(still(how, 28)));
  EXPECT_EQ(finding.code, "coarse_thermometer");
  EXPECT_EQ(finding.severity, Severity::warn);
  EXPECT_NE(finding.text.find("1 K"), std::string::npos) << finding.text;
  how.temp_lsb_c = 0.25;
  expect_clean(still(how, 28));
  // One that stands on a whole degree throughout shows no step; the type may state it.
  UnitType type;
  type.temp_lsb_c = 1.0;
  EXPECT_EQ(only(findings_of(still({.temp_lsb_c = 1.0}, 29), type)).code, "coarse_thermometer");
}

TEST(DataGate, AcceptsWhatIsNotRejected) {
  Segment whole;
  whole.sensor.fill({10, 1.0, 1.0, 1.0});
  whole.blocks.resize(2);
  for (Block& block : whole.blocks) block.sensor = whole.sensor;
  whole.findings = {{"dropouts", Severity::warn, Sensor::gyro_x, "few"}};
  Segment part = whole;
  part.findings.push_back({"stuck", Severity::reject, Sensor::accel_x, "0.25"});
  Segment none = whole;
  none.findings.push_back({"moved", Severity::reject, std::nullopt, "by 3 deg"});
  EXPECT_FALSE(is_rejected(part));
  EXPECT_TRUE(is_rejected(part, Sensor::accel_x));
  EXPECT_TRUE(is_rejected(none));
  EXPECT_TRUE(is_rejected(none, Sensor::gyro_z));

  const std::vector<Segment> all = {whole, part, none};
  const auto kept = accepted(all);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].sensor[3].count, 10U);
  EXPECT_EQ(kept[1].sensor[3].count, 0U);
  EXPECT_EQ(kept[1].blocks[1].sensor[3].count, 0U);
  EXPECT_EQ(kept[1].sensor[0].count, 10U);

  const auto warnings = gate_warnings(all);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_EQ(warnings[0].code, "dropouts");
  EXPECT_TRUE(base::mentions(warnings[0].text, {"3 of 3 segments", "visit 0", "few"}));
  EXPECT_TRUE(base::mentions(warnings[2].text, {"1 of 3 segments", "visit 0", "by 3 deg"}));
}

/// Rows of numbers of a text file, without its header line.
std::vector<std::vector<double>> table_of(const std::filesystem::path& path, bool header) {
  std::ifstream file(path);
  std::string line;
  if (header) std::getline(file, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::vector<double> row;
    for (double value = 0.0; words >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

std::filesystem::path shared_data(const char* folder) {
  const char* const base = std::getenv("SOAK_TEST_DATA");
  const auto shared = std::filesystem::path(SOAK_TEST_FOLDER) / ".." / ".." / "shared" / "data";
  return (base != nullptr ? std::filesystem::path(base) : shared) / folder;
}

TEST(DataGate, FindsNoMotionInTheChamberRecording) {
  const auto path = shared_data("thermal_chamber_cycle") / "imu_raw_data.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the chamber recording is not here (SOAK_TEST_DATA)";
  Recording r;
  for (const auto& row : table_of(path, true)) {
    r.t_s.push_back(row[0] * 1e-6);
    for (std::size_t s = 0; s < kSensorCount; ++s) r.sensor[s].push_back(row[1 + s]);
    r.temp_c.push_back(row[8]);
  }
  // 92 K of thermal drift, 3 deg/s of it on gyro y, in one attitude; only the first row is an outlier (PROVENANCE.md).
  const Finding finding = only(findings_of(r));
  EXPECT_EQ(finding.code, "knocked");
  EXPECT_EQ(finding.severity, Severity::warn);
  EXPECT_NE(finding.text.find("1 "), std::string::npos) << finding.text;
}

TEST(DataGate, PassesTheStandstillsOfAHandTurnedRecording) {
  const auto folder = shared_data("multi_position_xsens");
  if (!std::filesystem::exists(folder / "xsens_acc.mat")) {
    GTEST_SKIP() << "the multi-position recording is not here (SOAK_TEST_DATA)";
  }
  const auto accel = table_of(folder / "xsens_acc.mat", false);
  const auto gyro = table_of(folder / "xsens_gyro.mat", false);
  ASSERT_EQ(accel.size(), gyro.size());
  // Factory offset and scale in counts, PROVENANCE.md.
  constexpr std::array kAccelOffset = {33123.0, 33276.0, 32360.0};
  constexpr std::array kGyroOffset = {32768.0, 32466.0, 32485.0};
  Recording all;
  for (std::size_t i = 0; i < accel.size(); ++i) {
    all.t_s.push_back(accel[i][0]);
    all.temp_c.push_back(25.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.sensor[axis].push_back((gyro[i][1 + axis] - kGyroOffset[axis]) / 4766.0);
      all.sensor[3 + axis].push_back((accel[i][1 + axis] - kAccelOffset[axis]) / 414.5);
    }
  }
  // PROVENANCE.md: 38 static positions with turns between.
  EXPECT_EQ(segment(all)->segments.size(), 38U);
  expect_clean(all);
  // The first 50 s lie still (38 positions follow).
  Recording rest = all;
  const auto end = std::lower_bound(rest.t_s.begin(), rest.t_s.end(), rest.t_s.front() + 45.0) - rest.t_s.begin();
  const auto keep = [&](std::vector<double>& values) { values.resize(static_cast<std::size_t>(end)); };
  keep(rest.t_s);
  keep(rest.temp_c);
  for (auto& values : rest.sensor) keep(values);
  expect_clean(rest);
}

}  // namespace
}  // namespace soak::calib
