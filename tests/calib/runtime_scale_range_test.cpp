// SPDX-License-Identifier: Apache-2.0
// A scale factor that was measured at fewer temperatures than the bias: who reads the file is told where.
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "calib/deploy/calibration_file.h"
#include "calib/deploy/export.h"
#include "calib/deploy/table_form.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/loaded_file.h"

namespace soak::calib {
namespace {

using namespace samples;
using Six = std::array<float, 6>;

constexpr Six kReadings = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};

/// accel_x valid from -30 to 70 °C, its scale known from 0.25 to 60.5 °C only.
Calibration with_scale(const Curve& scale_ppm) {
  Calibration calibration = with_bias(spline(0.1), Sensor::accel_x);
  calibration.sensors[0].scale_ppm = scale_ppm;
  return calibration;
}

anfis::Model partial_model() {
  anfis::Model model = fis(3, anfis::Shape::gaussian, 1500.0, 400.0);
  model.inputs[0].min = 0.25;
  model.inputs[0].max = 60.5;
  return model;
}

std::vector<std::pair<std::string, Calibration>> forms() {
  const Calibration model = with_scale(partial_model());
  const Calibration line = with_scale(SplineCurve{{0.25, 60.5}, {{500.0, 8.0, 0.0, 0.0}}});
  return {{"FIS", model},
          {"spline", line},
          {"table", with_scale(TableCurve{0.25, 60.25, {500.0, 900.0}})},
          {"table form of a FIS", *table_form(model, 200)},
          {"coarse table form of a FIS", *table_form(model, 7)},
          {"table form of a spline", *table_form(line, 50)}};
}

soak_status scale_at(const Loaded& file, float temp_c, float* value) {
  return soak_scale_ppm(&file.cal, SOAK_ACCEL_X, temp_c, value);
}

TEST(ScaleRange, OutsideItTheRuntimeHoldsTheScaleAndSaysSo) {
  for (const auto& [name, calibration] : forms()) {
    const Loaded file(calibration);
    float at_end = 0.0F;
    float value = 0.0F;
    ASSERT_EQ(scale_at(file, 0.25F, &at_end), SOAK_OK) << name;
    for (const float temp_c : {-30.0F, -3.5F, 0.2F}) {
      EXPECT_EQ(scale_at(file, temp_c, &value), SOAK_CLAMPED) << name << ' ' << temp_c;
      EXPECT_NEAR(value, at_end, 1e-2F) << name;
    }
    EXPECT_EQ(scale_at(file, 60.5F, &value), SOAK_OK) << name;
    EXPECT_EQ(scale_at(file, 60.55F, &value), SOAK_CLAMPED) << name;
    EXPECT_EQ(scale_at(file, 90.0F, &value), SOAK_CLAMPED) << name;
    EXPECT_EQ(soak_bias(&file.cal, SOAK_ACCEL_X, -30.0F, &value), SOAK_OK) << name;
  }
}

TEST(ScaleRange, ACorrectedSampleIsFlaggedOutsideIt) {
  for (const auto& [name, calibration] : forms()) {
    const Loaded file(calibration);
    Six out{};
    std::uint32_t flags = 0;
    const std::uint32_t others = 0x00003F00U & ~SOAK_FLAG_ABSENT(3U);
    EXPECT_EQ(soak_apply(&file.cal, -10.0F, kReadings.data(), out.data(), &flags), SOAK_ABSENT);
    EXPECT_EQ(flags, SOAK_FLAG_SCALE(3U) | others) << name;
    EXPECT_NE(out[3], kReadings[3]) << name;
    EXPECT_EQ(soak_apply(&file.cal, 20.0F, kReadings.data(), out.data(), &flags), SOAK_ABSENT);
    EXPECT_EQ(flags, others) << name;
    // beyond the valid range nothing was measured at all, which is said once
    EXPECT_EQ(soak_apply(&file.cal, -40.0F, kReadings.data(), out.data(), &flags), SOAK_ABSENT);
    EXPECT_EQ(flags, SOAK_FLAG_CLAMPED(3U) | others) << name;
  }
}

TEST(ScaleRange, AloneIsNotOk) {
  Calibration calibration = golden_fis();
  std::get<anfis::Model>(*calibration.sensors[4].scale_ppm).inputs[0].max = 50.0;
  const Loaded file(calibration);
  Six out{};
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply(&file.cal, 50.0F, kReadings.data(), out.data(), &flags), SOAK_OK);
  EXPECT_EQ(soak_apply(&file.cal, 50.01F, kReadings.data(), out.data(), &flags), SOAK_CLAMPED);
  EXPECT_EQ(flags, SOAK_FLAG_SCALE(4U));
}

TEST(ScaleRange, ThatIsTheValidRangeIsNeverFlaggedInAnyForm) {
  for (const Calibration& calibration : {golden_fis(), golden_table(), *table_form(golden_fis(), 9)}) {
    const Loaded file(calibration);
    for (int i = 0; i <= 1000; ++i) {
      Six out{};
      std::uint32_t flags = 0;
      const float temp_c = -30.0F + 0.1F * static_cast<float>(i);
      if (temp_c > 70.0F) continue;
      EXPECT_EQ(soak_apply(&file.cal, temp_c, kReadings.data(), out.data(), &flags), SOAK_OK) << temp_c;
    }
  }
}

TEST(ScaleRange, JsonHasNoScaleOutsideItAndTheCHeaderNamesIt) {
  const Calibration calibration = with_scale(partial_model());
  const auto document = nlohmann::json::parse(*export_json(calibration));
  std::size_t known = 0;
  for (const auto& point : document["sensors"]["accel_x"]["curve"]) {
    const double temp_c = point["temp_c"].get<double>();
    EXPECT_EQ(point["scale_ppm"].is_number(), temp_c >= 0.25 && temp_c <= 60.5) << temp_c;
    known += point["scale_ppm"].is_number() ? 1 : 0;
  }
  EXPECT_EQ(known, 60U);  // 1, 2 ... 60 °C
  EXPECT_NE(export_c(calibration)->find("scale measured from 0.25 to 60.5 degC only"), std::string::npos);
}

}  // namespace
}  // namespace soak::calib
