// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/loaded_file.h"

namespace soak::calib {
namespace {

using namespace samples;

constexpr float kNoReading = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
using Six = std::array<float, 6>;

/// A file and the runtime's view of it.
struct Applied {
  soak_status status;
  Six out;
  std::uint32_t flags;
};

Applied apply(const soak_cal& cal, float temp_c, const Six& raw) {
  Applied result{};
  result.status = soak_apply(&cal, temp_c, raw.data(), result.out.data(), &result.flags);
  return result;
}

// The reading of a unit with the given truth, by the equations of docs/blob-format.md §5 in double precision.
Six reading(const Calibration& calibration, double temp_c, const std::array<double, 6>& truth) {
  std::array<double, 6> raw = truth;
  for (const SensorCalibration& sensor : calibration.sensors) {
    const std::size_t i = index_of(sensor.sensor);
    const double scale_ppm = sensor.scale_ppm ? evaluate(*sensor.scale_ppm, temp_c) : 0.0;
    raw[i] = (1.0 + 1e-6 * scale_ppm) * truth[i] + evaluate(sensor.bias, temp_c);
    for (std::size_t j = 0; j < 3; ++j) {
      const auto& cross = i < 3 ? calibration.g_sensitivity : calibration.accel_misalignment;
      if (cross) raw[i] += (*cross)[i % 3][j] * truth[3 + j];
    }
  }
  Six rounded{};
  for (std::size_t i = 0; i < 6; ++i) rounded[i] = static_cast<float>(raw[i]);
  return rounded;
}

TEST(Runtime, CorrectionUndoesTheSensorsErrors) {
  Calibration calibration = golden_mixed();
  calibration.sensors.push_back(calibration.sensors[0]);
  calibration.sensors.back().sensor = Sensor::gyro_y;
  calibration.sensors[0].scale_ppm = spline(2000.0);  // rate positions gave gyro_x a scale
  const Loaded file(calibration);
  const std::array<double, 6> truth = {0.5, -1.25, 0.125, 3.0, -9.0, 2.0};
  for (const double temp_c : {-25.0, -3.5, 20.0, 41.25, 65.0}) {
    const Applied result = apply(file.cal, static_cast<float>(temp_c), reading(calibration, temp_c, truth));
    EXPECT_EQ(result.status, SOAK_OK);
    EXPECT_EQ(result.flags, 0U);
    // float32 steps at 9 m/s² and 1 rad/s are 1e-6 and 1e-7; a dozen operations
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_NEAR(static_cast<double>(result.out[i]), truth[i], i < 3 ? 5e-7 : 5e-6) << i;
  }
}

TEST(Runtime, InPlaceCorrectionIsTheSame) {
  const Loaded file(golden_mixed());
  Six values = {0.1F, 0.2F, 0.3F, 1.0F, 2.0F, -9.8F};
  const Applied apart = apply(file.cal, 12.5F, values);
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply(&file.cal, 12.5F, values.data(), values.data(), &flags), apart.status);
  EXPECT_EQ(values, apart.out);
  EXPECT_EQ(flags, apart.flags);
}

TEST(Runtime, TemperatureOutOfRangeGivesTheEndAndSaysSoTwice) {
  const Loaded file(golden_fis());
  for (const auto& [outside, end] : {std::pair{-30.01F, -30.0F}, {70.5F, 70.0F}, {1e30F, 70.0F}, {-1e30F, -30.0F}}) {
    float at_end = 0.0F;
    float value = 0.0F;
    ASSERT_EQ(soak_bias(&file.cal, SOAK_GYRO_Y, end, &at_end), SOAK_OK);
    EXPECT_EQ(soak_bias(&file.cal, SOAK_GYRO_Y, outside, &value), SOAK_CLAMPED);
    EXPECT_EQ(value, at_end);
    EXPECT_EQ(soak_scale_ppm(&file.cal, SOAK_ACCEL_Z, outside, &value), SOAK_CLAMPED);
    const Applied result = apply(file.cal, outside, {});
    EXPECT_EQ(result.status, SOAK_CLAMPED);
    EXPECT_EQ(result.flags, 0x3FU);
    EXPECT_EQ(result.out, apply(file.cal, end, {}).out);
  }
}

TEST(Runtime, RangeIsReported) {
  const Loaded file(golden_mixed());
  float low = 0.0F;
  float high = 0.0F;
  EXPECT_EQ(soak_temp_range(&file.cal, SOAK_ACCEL_X, &low, &high), SOAK_OK);
  EXPECT_EQ(low, -25.0F);
  EXPECT_EQ(high, 65.0F);
  EXPECT_EQ(soak_temp_range(&file.cal, SOAK_GYRO_Y, &low, &high), SOAK_ABSENT);
}

TEST(Runtime, SensorThatTheFileLacksPassesThroughFlagged) {
  const Loaded file(golden_mixed());
  float value = 0.0F;
  EXPECT_EQ(soak_bias(&file.cal, SOAK_GYRO_Y, 20.0F, &value), SOAK_ABSENT);
  EXPECT_TRUE(std::isnan(value));
  const Applied result = apply(file.cal, 20.0F, {0.1F, 0.2F, 0.3F, 0.0F, 0.0F, 9.8F});
  EXPECT_EQ(result.status, SOAK_ABSENT);
  EXPECT_EQ(result.flags, SOAK_FLAG_ABSENT(1U));
  EXPECT_EQ(result.out[1], 0.2F);
}

TEST(Runtime, UnknownScaleIsAbsentNotZero) {
  const Loaded file(golden_fis());
  float value = 0.0F;
  EXPECT_EQ(soak_scale_ppm(&file.cal, SOAK_GYRO_X, 20.0F, &value), SOAK_ABSENT);
  EXPECT_TRUE(std::isnan(value));
}

TEST(Runtime, TemperatureThatIsNoNumberLeavesAllSensorsUncorrected) {
  const Loaded file(golden_fis());
  const Six raw = {0.1F, 0.2F, 0.3F, 1.0F, 2.0F, 9.8F};
  for (const float temp_c : {kNoReading, kInfinity, -kInfinity}) {
    const Applied result = apply(file.cal, temp_c, raw);
    EXPECT_EQ(result.status, SOAK_INVALID);
    EXPECT_EQ(result.flags & 0x003F0000U, 0x003F0000U);
    EXPECT_EQ(result.out, raw);
    float value = 0.0F;
    EXPECT_EQ(soak_bias(&file.cal, SOAK_GYRO_X, temp_c, &value), SOAK_INVALID);
    EXPECT_TRUE(std::isnan(value));
  }
}

TEST(Runtime, OneBadAccelerometerDoesNotSpoilTheOthers) {
  const Loaded file(golden_mixed());
  const Six good = {0.1F, 0.2F, 0.3F, 1.0F, 2.0F, 9.8F};
  const Applied expected = apply(file.cal, 20.0F, good);
  for (const float bad : {kNoReading, kInfinity}) {
    Six raw = good;
    raw[3] = bad;
    const Applied result = apply(file.cal, 20.0F, raw);
    EXPECT_EQ(result.status, SOAK_INVALID);
    EXPECT_EQ(result.flags, SOAK_FLAG_INVALID(3U) | SOAK_FLAG_ABSENT(1U) | SOAK_FLAG_UNCOUPLED);
    EXPECT_FALSE(std::isfinite(result.out[3]));
    // what is left out is at most 0.003 and 1e-4 (rad/s)/(m/s²) of the lost 1 m/s²
    for (const std::size_t i : {0U, 2U}) EXPECT_NEAR(result.out[i], expected.out[i], 2e-4F);
    for (const std::size_t i : {4U, 5U}) EXPECT_NEAR(result.out[i], expected.out[i], 4e-3F);
  }
}

TEST(Runtime, OneBadGyroSpoilsOnlyItself) {
  const Loaded file(golden_fis());
  Six raw = {0.1F, 0.2F, 0.3F, 1.0F, 2.0F, 9.8F};
  const Applied expected = apply(file.cal, 20.0F, raw);
  raw[0] = kNoReading;
  const Applied result = apply(file.cal, 20.0F, raw);
  EXPECT_EQ(result.flags, SOAK_FLAG_INVALID(0U));
  EXPECT_TRUE(std::isnan(result.out[0]));
  for (std::size_t i = 1; i < 6; ++i) EXPECT_EQ(result.out[i], expected.out[i]);
}

TEST(Runtime, ImplausibleScaleLeavesTheSensorOutLikeAReadingThatIsNoNumber) {
  Loaded file(golden_mixed());
  const std::size_t curve = payload_of(file.bytes, SOAK_SECTION_SPLINE, 3, 1);
  ASSERT_GT(curve, 0U);
  put(file.bytes, curve + 8, 1e-30F);  // half range: the curve is its centre
  Six raw = {0.1F, 0.2F, 0.3F, 1.0F, 2.0F, 9.8F};
  for (const float scale_ppm : {500000.0F, -500000.0F, 500000.06F, -600000.0F}) {
    put(file.bytes, curve + 4, scale_ppm);
    seal(file.bytes);
    ASSERT_EQ(soak_load(&file.cal, file.bytes.data(), file.bytes.size()), SOAK_OK);
    const Applied result = apply(file.cal, 20.0F, raw);
    if (std::abs(scale_ppm) == 500000.0F) {
      EXPECT_EQ(result.flags, SOAK_FLAG_ABSENT(1U));
      continue;
    }
    EXPECT_EQ(result.flags, SOAK_FLAG_INVALID(3U) | SOAK_FLAG_ABSENT(1U) | SOAK_FLAG_UNCOUPLED);
    EXPECT_EQ(result.out[3], raw[3]);
    Six without = raw;
    without[3] = kNoReading;
    const Applied expected = apply(file.cal, 20.0F, without);
    for (const std::size_t i : {0U, 2U, 4U, 5U}) EXPECT_EQ(result.out[i], expected.out[i]);
  }
}

TEST(Runtime, ReadingsTooLargeForFloat32AreFlagged) {
  const Loaded file(golden_mixed());
  constexpr float kMax = std::numeric_limits<float>::max();
  const Applied result =
      apply(file.cal, 20.0F, {kMax, 0.0F, 0.0F, kMax, -kMax, kMax});  // x: 1 + 0.002 + 0.001 times kMax
  EXPECT_EQ(result.status, SOAK_INVALID);
  EXPECT_NE(result.flags & SOAK_FLAG_INVALID(3U), 0U);
  EXPECT_EQ(result.out[3], kMax);
  for (const float value : result.out) EXPECT_TRUE(std::isfinite(value));
}

TEST(Runtime, UncertaintyIsLinearBetweenItsPointsAndHeldBeyond) {
  const Loaded file(golden_fis());  // ci95 1e-4, 0.5e-4, 2e-4 at -30, 20, 70 °C; pi95 5e-4, 5e-4, 7.5e-4
  float ci95 = 0.0F;
  float pi95 = 0.0F;
  EXPECT_EQ(soak_uncertainty(&file.cal, SOAK_GYRO_X, -5.0F, &ci95, &pi95), SOAK_OK);
  EXPECT_FLOAT_EQ(ci95, 0.75e-4F);
  EXPECT_FLOAT_EQ(pi95, 5e-4F);
  EXPECT_EQ(soak_uncertainty(&file.cal, SOAK_GYRO_X, 45.0F, &ci95, &pi95), SOAK_OK);
  EXPECT_FLOAT_EQ(ci95, 1.25e-4F);
  EXPECT_FLOAT_EQ(pi95, 6.25e-4F);
  EXPECT_EQ(soak_uncertainty(&file.cal, SOAK_GYRO_X, 100.0F, &ci95, &pi95), SOAK_CLAMPED);
  EXPECT_FLOAT_EQ(ci95, 2e-4F);
  EXPECT_EQ(soak_uncertainty(&file.cal, SOAK_GYRO_X, kNoReading, &ci95, &pi95), SOAK_INVALID);
  EXPECT_TRUE(std::isnan(ci95) && std::isnan(pi95));
}

TEST(Runtime, NullPointersAndForeignSensorsAreRefused) {
  const Loaded file(golden_fis());
  float value = 0.0F;
  std::uint32_t flags = 0;
  soak_cal cal;
  EXPECT_EQ(soak_load(nullptr, file.bytes.data(), file.bytes.size()), SOAK_E_ARGUMENT);
  EXPECT_EQ(soak_load(&cal, nullptr, 0), SOAK_E_ARGUMENT);
  EXPECT_EQ(soak_bias(&file.cal, SOAK_GYRO_X, 20.0F, nullptr), SOAK_E_ARGUMENT);
  EXPECT_EQ(soak_bias(&file.cal, 6, 20.0F, &value), SOAK_E_ARGUMENT);
  EXPECT_EQ(soak_bias(&file.cal, -1, 20.0F, &value), SOAK_E_ARGUMENT);
  EXPECT_EQ(soak_apply(&file.cal, 20.0F, &value, &value, nullptr), SOAK_E_ARGUMENT);
  EXPECT_EQ(soak_apply(nullptr, 20.0F, &value, &value, &flags), SOAK_E_ARGUMENT);
}

TEST(Runtime, RefusedFileLeavesAnEmptyCalibration) {
  base::Bytes bytes = *encode(golden_fis());
  bytes[bytes.size() / 2] ^= 1U;
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_E_CHECK);
  const Six raw = {0.1F, 0.2F, 0.3F, 1.0F, 2.0F, 9.8F};
  const Applied result = apply(cal, 20.0F, raw);
  EXPECT_EQ(result.status, SOAK_ABSENT);
  EXPECT_EQ(result.out, raw);
}

TEST(Runtime, SaysWhetherTheFileIsSimulated) {
  EXPECT_EQ(Loaded(golden_fis()).cal.simulated, 0U);
  EXPECT_NE(Loaded(golden_mixed()).cal.simulated, 0U);
}

TEST(Runtime, SaysWhetherTheFileIsNotReleased) {
  EXPECT_EQ(Loaded(golden_mixed()).cal.unreleased, 0U);
  EXPECT_NE(Loaded(golden_unreleased()).cal.unreleased, 0U);
  EXPECT_EQ(Loaded(golden_unreleased()).cal.simulated, 0U);
}

TEST(Runtime, ReadsAFileAtAnyAddress) {
  const base::Bytes bytes = *encode(golden_fis());
  float expected = 0.0F;
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  ASSERT_EQ(soak_bias(&cal, SOAK_ACCEL_X, 33.0F, &expected), SOAK_OK);
  for (std::size_t shift = 1; shift < 4; ++shift) {
    base::Bytes shifted(shift, 0);
    shifted.insert(shifted.end(), bytes.begin(), bytes.end());
    float value = 0.0F;
    ASSERT_EQ(soak_load(&cal, shifted.data() + shift, bytes.size()), SOAK_OK);
    ASSERT_EQ(soak_bias(&cal, SOAK_ACCEL_X, 33.0F, &value), SOAK_OK);
    EXPECT_EQ(value, expected);
  }
}

}  // namespace
}  // namespace soak::calib
