// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export_kalibr.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calib/signal/noise/noise.h"
#include "tests/calib/export_cubic_samples.h"
#include "tests/signal/filtered_noise.h"

namespace soak::calib {
namespace {

using samples::parameter_lines;

constexpr double kRadPerDeg = 0.017453292519943295;

/// `hours` at rest at 10 Hz with white noise N and random walk K, in printed units.
SignalRecord record(std::uint64_t seed, double hours, double density, double walk) {
  const auto count = static_cast<std::size_t>(36000.0 * hours);
  SignalRecord result{"gyro_x", "deg/s", 10.0, {}, signal::white_noise(count, density, {10.0, seed})};
  const auto slow = signal::random_walk(count, walk, {10.0, seed + 1});
  for (std::size_t i = 0; i < count; ++i) {
    result.t_s.push_back(static_cast<double>(i) / 10.0);
    result.values[i] += slow[i];
  }
  return result;
}

AxisNoise axis(Sensor sensor, double density, double walk, bool found = true) {
  const signal::AllanCoefficient n{density, 0.9 * density, 1.1 * density, true};
  const signal::AllanCoefficient k = found ? signal::AllanCoefficient{walk, 0.5 * walk, 2.0 * walk, true}
                                           : signal::AllanCoefficient{0.0, 0.0, walk, false};
  return {sensor, n, k, 100.0, 1200.0, 0.5};
}

std::vector<AxisNoise> six_axes() {
  return {axis(Sensor::gyro_x, 1e-4, 1e-6),  axis(Sensor::gyro_y, 3e-4, 2e-6),  axis(Sensor::gyro_z, 2e-4, 5e-6, false),
          axis(Sensor::accel_x, 2e-3, 1e-5), axis(Sensor::accel_y, 1e-3, 4e-5), axis(Sensor::accel_z, 1e-3, 2e-5)};
}

std::map<std::string, std::string> yaml(const std::string& text) {
  std::map<std::string, std::string> values;
  for (const auto& words : parameter_lines(text)) {
    EXPECT_TRUE(words[0].ends_with(":"));
    values[words[0].substr(0, words[0].size() - 1)] = words[1];
  }
  return values;
}

TEST(KalibrNoise, OfAGyroIsFoundInRadians) {
  const auto noise = axis_noise(Sensor::gyro_x, record(11, 2.0, 0.01, 0.0003));
  ASSERT_TRUE(noise) << noise.error().message;
  // The truth lies within the 95 % intervals that the fit states (their coverage is tested with the fit).
  EXPECT_TRUE(noise->density.found && noise->random_walk.found);
  EXPECT_GT(0.01 * kRadPerDeg, noise->density.low);
  EXPECT_LT(0.01 * kRadPerDeg, noise->density.high);
  EXPECT_GT(0.0003 * kRadPerDeg, noise->random_walk.low);
  EXPECT_LT(0.0003 * kRadPerDeg, noise->random_walk.high);
  EXPECT_NEAR(noise->longest_tau_s, 2400.0, 0.2);  // a third of 7200 s
  EXPECT_EQ(noise->rate_hz, 10.0);
}

TEST(KalibrNoise, OfAnAccelerometerStaysInMetres) {
  const auto noise = axis_noise(Sensor::accel_x, record(12, 1.0, 0.002, 0.0));
  ASSERT_TRUE(noise);
  EXPECT_NEAR(noise->density.value, 0.002, 0.0002);  // half an hour of white noise gives N to better than 2 %
  EXPECT_GT(noise->random_walk.high, 0.0);
}

TEST(KalibrNoise, OfAShortRecordIsRefusedWithWhatToRecord) {
  EXPECT_TRUE(axis_noise(Sensor::gyro_x, record(13, 0.5, 0.01, 0.0)));
  const auto noise = axis_noise(Sensor::gyro_x, record(13, 0.4, 0.01, 0.0));
  ASSERT_FALSE(noise);
  EXPECT_EQ(noise.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(noise.error().where, "gyro_x");
}

/// An hour of a gyro behind a low-pass, by a generator apart from calib.
TEST(KalibrNoise, DensityBehindALowPassIsThatOfThePlateau) {
  for (const double corner_hz : {5.0, 42.0}) {
    const filtered_noise::Unit unit{
        .filter = "butter2", .corner_hz = corner_hz, .rate_hz = 200.0, .length_s = 2400.0, .white = 0.01};
    const filtered_noise::Record made = filtered_noise::make_record(unit, 17);
    const auto noise = axis_noise(Sensor::gyro_x, {"gyro_x", "deg/s", unit.rate_hz, {}, made.rate, {}});
    ASSERT_TRUE(noise) << noise.error().message;
    ASSERT_TRUE(noise->density.found);
    // Beyond 0.6 s, the longer of the two, there are 4000 independent differences: N to 1.5 %, half as much again for
    // the filter's lag. Bound: four of these.
    EXPECT_NEAR(noise->density.value / (made.density * kRadPerDeg), 1.0, 0.09) << corner_hz;
    ASSERT_TRUE(noise->low_pass);
    EXPECT_NEAR(noise->low_pass->half_power_hz().value_or(0.0) / corner_hz, 1.0, 0.1);
  }
}

TEST(ExportKalibr, ATemperatureThatSwingsIsToldInTheFile) {
  const auto swinging =
      export_kalibr({.unit = "SN1", .temp_c = 27.4, .least_temp_c = -17.6, .most_temp_c = 74.0}, six_axes());
  ASSERT_TRUE(swinging);
  EXPECT_NE(swinging->text.find("-17.6 to 74.0"), std::string::npos);
  EXPECT_NE(swinging->text.find("91.6 K"), std::string::npos);
  const auto steady =
      export_kalibr({.unit = "SN1", .temp_c = 25.0, .least_temp_c = 24.9, .most_temp_c = 25.2}, six_axes());
  ASSERT_TRUE(steady);
  EXPECT_EQ(steady->text.find("NOT CONSTANT"), std::string::npos);
}

TEST(ExportKalibr, WritesTheWorstAxisOfEachKind) {
  const auto file = export_kalibr({.unit = "SN1", .run = "R1"}, six_axes());
  ASSERT_TRUE(file) << file.error().message;
  const auto values = yaml(file->text);
  ASSERT_EQ(values.size(), 6U);
  EXPECT_EQ(values.at("rostopic"), "/imu0");
  EXPECT_EQ(std::stod(values.at("update_rate")), 100.0);
  EXPECT_EQ(std::stod(values.at("gyroscope_noise_density")), 3e-4);
  EXPECT_EQ(std::stod(values.at("gyroscope_random_walk")), 5e-6);
  EXPECT_EQ(std::stod(values.at("accelerometer_noise_density")), 2e-3);
  EXPECT_EQ(std::stod(values.at("accelerometer_random_walk")), 4e-5);
  // PyYAML reads 5e-06 as a text: the dot must be there.
  for (const auto& [key, value] : values) EXPECT_TRUE(key == "rostopic" || value.find('.') != std::string::npos) << key;
}

TEST(ExportKalibr, ATermThatWasNotFoundIsWrittenAsItsUpperBoundAndSaysSo) {
  const auto file = export_kalibr({.unit = "SN1", .run = "R1"}, six_axes());
  const std::size_t bound = file->text.find("UPPER BOUND");
  ASSERT_NE(bound, std::string::npos);
  EXPECT_EQ(file->text.find("UPPER BOUND", bound + 1), std::string::npos);
  EXPECT_LT(bound, file->text.find("gyroscope_random_walk: "));
  EXPECT_GT(bound, file->text.find("gyroscope_noise_density: "));
  EXPECT_NE(file->text.find("gyro_z: not found, at most 5.000e-06"), std::string::npos);
  EXPECT_TRUE(file->values[3].bound);
  EXPECT_EQ(file->values[3].worst, Sensor::gyro_z);
}

TEST(ExportKalibr, RefusesWhatKalibrRefuses) {
  std::vector<AxisNoise> gyros = six_axes();
  gyros.resize(3);
  EXPECT_FALSE(export_kalibr({}, gyros));
  EXPECT_FALSE(export_kalibr({}, {}));
  for (const double bad : {0.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<AxisNoise> noise = six_axes();
    for (AxisNoise& one : noise) one.density.value = bad;
    EXPECT_FALSE(export_kalibr({}, noise)) << bad;
  }
}

}  // namespace
}  // namespace soak::calib
