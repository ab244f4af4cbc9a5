// SPDX-License-Identifier: Apache-2.0
#include "calib/model/model_document.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "anfis/model/one_input.h"

namespace soak::calib {
namespace {

using nlohmann::json;

/// A stored model of two rules per curve, without "fit", which is for people. The curves are those of commit f0a4981,
/// whose ANFIS was another program.
const char* const kDocument = R"({"format": "soak-model",
  "format_version": 2,
  "calibration": {"unit": "SN-0004",
    "unit_type": "demo",
    "epoch": 2,
    "model_version": 7,
    "created_utc_s": 1795248000.25,
    "simulated": false,
    "gravity_mps2": 9.8123,
    "gravity_assumed": false,
    "run_hashes": ["e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"],
    "sensors": [{"sensor": "gyro_x",
        "model": "anfis",
        "temp_min_c": -30.0,
        "temp_max_c": 70.0,
        "bias": {"kind": "fis",
          "model": {"format": "soak-anfis-model",
            "version": 2,
            "order": 1,
            "t_norm": "product",
            "inputs": [{"name": "temp_c",
                "centre": 20.0,
                "half_range": 50.0,
                "min": -30.0,
                "max": 70.0,
                "memberships": [{"shape": "bell", "width": 0.15, "slope": 1.5, "centre": -1.0},
                  {"shape": "bell", "width": 0.16999999999999998, "slope": 1.75, "centre": -0.6}]}],
            "output": {"centre": 0.01, "half_range": 0.004},
            "rules": [{"premise": [0], "gains": [0.0], "offset": 0.8},
              {"premise": [1], "gains": [0.3], "offset": 0.7000000000000001}]}},
        "bias_uncertainty": {"temp_c": [-30.0, 70.0], "ci95": [0.1, 0.2], "pi95": [0.5, 0.6]}},
      {"sensor": "accel_x",
        "model": "spline",
        "temp_min_c": -30.0,
        "temp_max_c": 70.0,
        "bias": {"kind": "spline", "knots_c": [-30.0, 70.0], "coefficients": [[0.25, 0.5, -0.125, 2.0]]},
        "bias_uncertainty": {"temp_c": [-30.0, 70.0], "ci95": [0.1, 0.2], "pi95": [0.5, 0.6]},
        "scale_ppm": {"kind": "fis",
          "model": {"format": "soak-anfis-model",
            "version": 2,
            "order": 1,
            "t_norm": "product",
            "inputs": [{"name": "temp_c",
                "centre": 20.0,
                "half_range": 50.0,
                "min": -30.0,
                "max": 70.0,
                "memberships": [{"shape": "gaussian", "width": 0.15, "centre": -1.0},
                  {"shape": "gaussian", "width": 0.16999999999999998, "centre": -0.6}]}],
            "output": {"centre": 1500.0, "half_range": 400.0},
            "rules": [{"premise": [0], "gains": [-0.8999999999999999], "offset": 0.9500000000000001},
              {"premise": [1], "gains": [-0.6], "offset": 0.8500000000000001}]}},
        "scale_uncertainty": {"temp_c": [-30.0, 70.0], "ci95": [0.1, 0.2], "pi95": []}}]}})";

struct Stored {
  double temp_c, gyro_bias, accel_scale_ppm;
};
/// What that program evaluated.
constexpr Stored kStored[] = {{-30.0, 0.01312721314245081, 2230.5489825113791},
                              {3.7, 0.012459770294783854, 1918.2519704387312},
                              {42.5, 0.013284917105054101, 1731.9999999999864},
                              {70.0, 0.013584801467009834, 1600.0}};

TEST(ModelDocument, GivesTheCurvesThatAnotherProgramEvaluated) {
  const auto calibration = calibration_of(kDocument);
  ASSERT_TRUE(calibration) << calibration.error().message;
  EXPECT_EQ(calibration->unit, "SN-0004");
  EXPECT_EQ(calibration->model_version, 7);
  ASSERT_EQ(calibration->sensors.size(), 2U);
  for (const Stored& stored : kStored) {
    // Memberships came from the mathematics library then; either is within 1e-14 of the definition.
    EXPECT_NEAR(evaluate(calibration->sensors[0].bias, stored.temp_c), stored.gyro_bias, 1e-13 * stored.gyro_bias);
    EXPECT_NEAR(evaluate(*calibration->sensors[1].scale_ppm, stored.temp_c), stored.accel_scale_ppm,
                1e-13 * stored.accel_scale_ppm);
  }
}

TEST(ModelDocument, KeepsEveryParameter) {
  const auto calibration = calibration_of(kDocument);
  ASSERT_TRUE(calibration);
  const auto& model = std::get<anfis::Model>(*calibration->sensors[1].scale_ppm);
  EXPECT_EQ(anfis::curve_shape(model), anfis::Shape::gaussian);
  EXPECT_EQ(model.inputs[0].scale, (anfis::Scale{20.0, 50.0}));
  EXPECT_EQ(model.inputs[0].min, -30.0);
  EXPECT_EQ(model.inputs[0].max, 70.0);
  EXPECT_EQ(model.output, (anfis::Scale{1500.0, 400.0}));
  const std::vector<anfis::CurveRule> rules = {{0.15, 0.0, -1.0, -0.8999999999999999, 0.9500000000000001},
                                               {0.16999999999999998, 0.0, -0.6, -0.6, 0.8500000000000001}};
  EXPECT_EQ(anfis::curve_rules(model), rules);
}

TEST(ModelDocument, RefusesAModelThatAsksForMoreThanTemperature) {
  json document = json::parse(kDocument);
  const json input = {{"name", "x"},       {"centre", 0.0},
                      {"half_range", 1.0}, {"min", -1.0},
                      {"max", 1.0},        {"memberships", {{{"shape", "gaussian"}, {"width", 1.0}, {"centre", 0.0}}}}};
  document["calibration"]["sensors"][0]["bias"]["model"] = {
      {"format", "soak-anfis-model"},
      {"version", 2},
      {"order", 0},
      {"t_norm", "product"},
      {"inputs", {input, input}},
      {"output", {{"centre", 0.0}, {"half_range", 1.0}}},
      {"rules", {{{"premise", {0, 0}}, {"gains", {0.0, 0.0}}, {"offset", 1.0}}}}};
  const auto calibration = calibration_of(document.dump());
  ASSERT_FALSE(calibration);
  EXPECT_EQ(calibration.error().kind, base::ErrorKind::corrupt);
}

TEST(ModelDocument, StatesItsFormat) {
  const auto document = model_document(UnitModel{});
  ASSERT_TRUE(document);
  EXPECT_EQ(json::parse(*document)["format_version"], 2);
}

}  // namespace
}  // namespace soak::calib
