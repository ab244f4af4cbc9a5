// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/schema_check.h"

namespace soak::calib {
namespace {

using namespace samples;
using nlohmann::json;

constexpr double kDegPerRad = 57.29577951308232;

json exported(const Calibration& calibration) {
  const auto text = export_json(calibration);
  EXPECT_TRUE(text) << text.error().message;
  return json::parse(*text);
}

TEST(ExportJson, KeepsItsSchema) {
  std::ifstream in(std::string(SOAK_TEST_FOLDER) + "/../docs/schema/calibration.schema.json");
  const tests::SchemaCheck schema(json::parse(in));
  for (const Calibration& calibration : {golden_fis(), golden_mixed()}) {
    json document = exported(calibration);
    EXPECT_EQ(schema.mistake(document), "");
    document["sensors"]["gyro_x"]["curve"][3]["bias"] = "0";
    EXPECT_EQ(schema.mistake(document), "/sensors/gyro_x/curve/3/bias: wrong type");
  }
}

TEST(ExportJson, CurveHasAPointEveryDegreeAndBothEnds) {
  Calibration calibration = golden_mixed();
  calibration.sensors[0].temp_max_c = 64.5;
  const json document = exported(calibration);
  const json& curve = document["sensors"]["gyro_x"]["curve"];
  ASSERT_EQ(curve.size(), 91U);  // -25, -24, ... 64, 64.5
  EXPECT_EQ(curve.front()["temp_c"], -25.0);
  EXPECT_EQ(curve[89]["temp_c"], 64.0);
  EXPECT_EQ(curve.back()["temp_c"], 64.5);
}

TEST(ExportJson, RatesAreInDegreesPerSecond) {
  const json document = exported(golden_mixed());
  const json& gyro = document["sensors"]["gyro_z"];  // spline of amplitude 0.03 rad/s: 0.5625 at 20 °C
  EXPECT_EQ(gyro["unit"], "deg/s");
  EXPECT_NEAR(gyro["curve"][45]["bias"].get<double>(), 0.03 * 0.5625 * kDegPerRad, 1e-12);
  EXPECT_NEAR(gyro["bias"]["coefficients"][2][0].get<double>(), 0.03 * 0.5625 * kDegPerRad, 1e-12);
  EXPECT_NEAR(gyro["bias_uncertainty"][0]["ci95"].get<double>(), 0.0002 * kDegPerRad, 1e-12);
  EXPECT_TRUE(gyro["scale_ppm"].is_null());
  const json& accel = document["sensors"]["accel_y"];  // table of amplitude 0.2 m/s²; scale spline of 2000 ppm
  EXPECT_EQ(accel["unit"], "m/s2");
  EXPECT_NEAR(accel["bias"]["values"][0].get<double>(), 0.2, 1e-15);
  EXPECT_NEAR(accel["curve"][45]["scale_ppm"].get<double>(), 1125.0, 1e-9);
  EXPECT_NEAR(document["g_sensitivity_dps_per_mps2"][0][0].get<double>(), 1e-4 * kDegPerRad, 1e-12);
  EXPECT_FALSE(document["sensors"].contains("gyro_y"));
}

TEST(ExportJson, ParametersOfAModelReproduceItsCurve) {
  const json document = exported(golden_fis());
  const json& sensor = document["sensors"]["gyro_y"];
  const json& m = sensor["bias"];
  for (const json& point : sensor["curve"]) {
    const double u =
        (point["temp_c"].get<double>() - m["input_centre"].get<double>()) / m["input_half_range"].get<double>();
    double top = 0.0;
    double bottom = 0.0;
    for (const json& rule : m["rules"]) {
      const double z = std::abs(u - rule["centre"].get<double>()) / rule["width"].get<double>();
      const double mu = 1.0 / (1.0 + std::pow(z, 2.0 * rule["slope"].get<double>()));
      top += mu * (rule["gain"].get<double>() * u + rule["offset"].get<double>());
      bottom += mu;
    }
    const double value = m["output_centre"].get<double>() + m["output_half_range"].get<double>() * top / bottom;
    EXPECT_NEAR(point["bias"].get<double>(), value, 1e-12);
  }
}

TEST(ExportJson, SaysWhatTheCalibrationIs) {
  const json document = exported(golden_mixed());
  EXPECT_EQ(document["unit"], "SN-0002");
  EXPECT_EQ(document["simulated"], true);
  EXPECT_EQ(document["unreleased"], false);
  EXPECT_EQ(exported(golden_unreleased())["unreleased"], true);
  EXPECT_EQ(document["gravity"], "assumed");
  EXPECT_EQ(document["created_utc"], "2026-11-21T08:00:00Z");  // date -u -d @1795248000
  EXPECT_EQ(document["terms"][0]["sensors"], json({"gyro_x", "gyro_z"}));
  EXPECT_EQ(document["terms"][0]["parameters"]["gyro_x"], 1e-4);
}

TEST(ExportJson, RefusesWhatJsonCannotCarry) {
  Calibration calibration = golden_mixed();
  calibration.sensors[1].bias_uncertainty.ci95[2] = std::numeric_limits<double>::infinity();
  const auto text = export_json(calibration);
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().where, "/sensors/gyro_z/bias_uncertainty/2/ci95");
}

TEST(ExportJson, RefusesModelsThatItsMembersCannotSay) {
  Calibration calibration = golden_fis();
  auto& model = std::get<anfis::Model>(*calibration.sensors[3].scale_ppm);
  model.inputs[0].memberships[2] = {anfis::Shape::triangle, {-1.0, 0.0, 1.0}};
  const auto text = export_json(calibration);
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(text.error().where, "/sensors/" + std::string(name_of(kSensors[3])) + "/scale_ppm/inputs[0].memberships");
}

}  // namespace
}  // namespace soak::calib
