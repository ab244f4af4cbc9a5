// SPDX-License-Identifier: Apache-2.0
// Accepted effects in the deployment runtime, against docs/gap-terms.md written out in double precision.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_terms.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/runtime_c/runtime_as_c.h"

namespace soak::calib {
namespace {

using namespace samples;
using Six = std::array<float, 6>;

constexpr double kRate_kps = 0.02;
constexpr double kTemp_c = 31.0;
constexpr std::array<double, 6> kTrueSix = {0.02, -0.01, 0.3, 1.5, -2.5, 9.3};

/// One effect of each kind that the runtime corrects, and two that it cannot; one accelerometer is not in the file.
Calibration with_terms() {
  Calibration calibration = golden_mixed();
  calibration.terms = {{"temperature_rate",
                        false,
                        {Sensor::gyro_x},
                        {{"per_kps", 0.01}, {"per_kps_per_c", 2e-4}, {"reference_c", 20.0}}},
                       {"temperature_rate", false, {Sensor::accel_z}, {{"per_kps", -0.4}}},
                       {"sensor_lag", false, {kSensors.begin(), kSensors.end()}, {{"factor", 0.9}, {"tau_s", 150.0}}},
                       {"cross_axis", false, {Sensor::accel_y}, {{"z", 2e-5}, {"x", -3e-5}, {"reference_c", 25.0}}},
                       {"thermal_hysteresis", true, {Sensor::gyro_y}, {{"amplitude", 1.0}, {"width_c", 6.0}}},
                       {"warmup_transient", true, {Sensor::gyro_y}, {{"amplitude", 1.0}, {"tau_s", 600.0}}}};
  return calibration;
}

/// What such a unit reads while its thermometer rises, by the formulas of the two documents.
Six moving_reading(const Calibration& calibration) {
  const double element_c = kTemp_c - 0.9 * 150.0 * kRate_kps;
  Six raw{};
  for (const SensorCalibration& sensor : calibration.sensors) {
    const std::size_t i = index_of(sensor.sensor);
    double value = kTrueSix[i] * (1.0 + 1e-6 * (sensor.scale_ppm ? evaluate(*sensor.scale_ppm, element_c) : 0.0)) +
                   evaluate(sensor.bias, element_c);
    const auto& cross = i < 3 ? calibration.g_sensitivity : calibration.accel_misalignment;
    for (std::size_t j = 0; cross && j < 3; ++j) value += (*cross)[i % 3][j] * kTrueSix[3 + j];
    if (sensor.sensor == Sensor::gyro_x) value += (0.01 + 2e-4 * (kTemp_c - 20.0)) * kRate_kps;
    if (sensor.sensor == Sensor::accel_z) value += -0.4 * kRate_kps;
    if (sensor.sensor == Sensor::accel_y) value += (kTemp_c - 25.0) * (2e-5 * kTrueSix[5] - 3e-5 * kTrueSix[3]);
    raw[i] = static_cast<float>(value);
  }
  return raw;
}

TEST(RuntimeTerms, CorrectWhatTheTemperatureAndItsRateTell) {
  const Calibration calibration = with_terms();
  const auto bytes = encode(calibration);
  ASSERT_TRUE(bytes) << bytes.error().message;
  const Six raw = moving_reading(calibration);
  Six out{};
  std::uint32_t flags = 0;
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes->data(), bytes->size()), SOAK_OK);
  soak_terms terms;
  ASSERT_EQ(soak_load_terms(&terms, &cal), SOAK_OK);
  EXPECT_EQ(terms.count, 4U);
  EXPECT_EQ(soak_apply_moving(&cal, &terms, static_cast<float>(kTemp_c), static_cast<float>(kRate_kps), raw.data(),
                              out.data(), &flags),
            SOAK_ABSENT);
  for (const SensorCalibration& sensor : calibration.sensors) {
    const std::size_t i = index_of(sensor.sensor);
    EXPECT_NEAR(out[i], kTrueSix[i], 2e-6 * (1.0 + std::abs(raw[i]))) << name_of(sensor.sensor);
  }
  Six in_c{};
  EXPECT_EQ(runtime_as_c_apply_moving(bytes->data(), bytes->size(), static_cast<float>(kTemp_c),
                                      static_cast<float>(kRate_kps), raw.data(), in_c.data(), &flags),
            SOAK_ABSENT);
  EXPECT_EQ(in_c, out);
}

TEST(RuntimeTerms, AFileWithoutThemIsCorrectedAsAlways) {
  Calibration calibration = golden_mixed();
  calibration.terms.clear();
  const auto bytes = *encode(calibration);
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  soak_terms terms;
  EXPECT_EQ(soak_load_terms(&terms, &cal), SOAK_ABSENT);
  const Six raw = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};
  Six moving{};
  Six still{};
  std::uint32_t flags_moving = 0;
  std::uint32_t flags_still = 0;
  EXPECT_EQ(soak_apply_moving(&cal, &terms, 18.0F, 0.5F, raw.data(), moving.data(), &flags_moving),
            soak_apply(&cal, 18.0F, raw.data(), still.data(), &flags_still));
  EXPECT_EQ(moving, still);
  EXPECT_EQ(flags_moving, flags_still);
}

TEST(RuntimeTerms, ARateThatCannotBeIsToldAndLeftOut) {
  const auto bytes = *encode(with_terms());
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  soak_terms terms;
  ASSERT_EQ(soak_load_terms(&terms, &cal), SOAK_OK);
  const Six raw = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};
  Six still{};
  std::uint32_t flags = 0;
  ASSERT_EQ(soak_apply_moving(&cal, &terms, 18.0F, 0.0F, raw.data(), still.data(), &flags), SOAK_ABSENT);
  for (const float rate : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1.5F}) {
    Six out{};
    EXPECT_EQ(soak_apply_moving(&cal, &terms, 18.0F, rate, raw.data(), out.data(), &flags), SOAK_INVALID);
    EXPECT_EQ(out, still);
  }
}

TEST(RuntimeTerms, WhatCannotBeCorrectedPassesUnchanged) {
  const auto bytes = *encode(with_terms());
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  soak_terms terms;
  ASSERT_EQ(soak_load_terms(&terms, &cal), SOAK_OK);
  const Six raw = {std::numeric_limits<float>::infinity(), -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};
  Six out{};
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply_moving(&cal, &terms, 18.0F, 0.02F, raw.data(), out.data(), &flags), SOAK_INVALID);
  EXPECT_EQ(out[0], raw[0]);
  EXPECT_EQ(flags & SOAK_FLAG_INVALID(0), SOAK_FLAG_INVALID(0));
}

TEST(RuntimeTerms, LoadingNeedsALoadedFile) {
  soak_cal cal;
  soak_terms terms;
  EXPECT_EQ(soak_load(&cal, "nothing", 7), SOAK_E_MAGIC);
  EXPECT_EQ(soak_load_terms(&terms, &cal), SOAK_E_ARGUMENT);
  EXPECT_EQ(soak_load_terms(nullptr, &cal), SOAK_E_ARGUMENT);
}

}  // namespace
}  // namespace soak::calib
