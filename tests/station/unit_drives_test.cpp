// SPDX-License-Identifier: Apache-2.0
// What a calibration buys on simulated drives; tests/cli/test_verify.py holds the figures against `soak nav impact`.
#include "station/nav/unit_drives.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/units.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// Gyros about right and forward whose bias changes by so much from -10 to 40 °C, known to 0.0001 deg/s.
calib::Calibration gyros(double change_dps) {
  calib::Calibration calibration;
  calibration.gravity_mps2 = 9.80665;
  for (const calib::Sensor name : {calib::Sensor::gyro_x, calib::Sensor::gyro_y}) {
    calib::SensorCalibration sensor;
    sensor.sensor = name;
    sensor.temp_min_c = -10.0;
    sensor.temp_max_c = 40.0;
    sensor.bias = calib::TableCurve{-10.0, 50.0, {0.0, change_dps * base::kRadPerDeg}};
    const std::vector<double> half_widths(2, 0.0001 * base::kRadPerDeg);
    sensor.bias_uncertainty = {{-10.0, 40.0}, half_widths, half_widths};
    calibration.sensors.push_back(std::move(sensor));
  }
  return calibration;
}

double final_m(const json& errors) { return errors["horizontal_final_m"]["value"].get<double>(); }

TEST(UnitDrives, ACurveThatIsSteepAndWellKnownIsWorthMetres) {
  const json drives = impact_with_drives_json(gyros(5.0))["drives"];
  EXPECT_EQ(drives["drives"], 4);
  EXPECT_EQ(drives["outages"], 24);
  EXPECT_LT(final_m(drives["with"]), 0.5 * final_m(drives["without"]));
  EXPECT_GT(drives["gain"]["ci95"][0].get<double>(), 0.5);
}

TEST(UnitDrives, ACurveThatIsFlatIsWorthNothing) {
  const json drives = impact_with_drives_json(gyros(0.0))["drives"];
  EXPECT_DOUBLE_EQ(final_m(drives["with"]), final_m(drives["without"]));
  EXPECT_NEAR(drives["gain"]["value"].get<double>(), 0.0, 1e-12);
}

TEST(UnitDrives, ACalibrationWithoutUncertaintyClaimsNothing) {
  calib::Calibration calibration = gyros(5.0);
  calibration.sensors[1].bias_uncertainty = {};
  const json impact = impact_with_drives_json(calibration);
  EXPECT_TRUE(impact["drives"].is_null());
  EXPECT_TRUE(impact["warnings"].empty());
}

TEST(UnitDrives, CurvesOfNoInertialUnitAreToldOfAndKeepTheRest) {
  const json impact = impact_with_drives_json(gyros(1e6));
  EXPECT_TRUE(impact["drives"].is_null());
  EXPECT_EQ(impact["free_inertial"].size(), 2u);
  ASSERT_EQ(impact["warnings"].size(), 1u);
  EXPECT_EQ(impact["warnings"][0]["code"], "drives_not_simulated");
}

TEST(UnitDrives, SensorsWithoutTwoCommonTemperaturesHaveNoImpact) {
  calib::Calibration calibration = gyros(5.0);
  calibration.sensors[1].temp_max_c = -10.0;
  EXPECT_TRUE(impact_with_drives_json(calibration).is_null());
}

}  // namespace
}  // namespace soak::station
