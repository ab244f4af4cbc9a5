// SPDX-License-Identifier: Apache-2.0
// What a calibration buys without satellite navigation; tests/cli/test_nav.py asks the same of a fitted unit.
#include "station/nav/free_inertial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/units.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// A gyro with a bias of 0.01 deg/s per kelvin from -10 to 40 °C and a ci95 and pi95 as given, in deg/s.
calib::SensorCalibration gyro(calib::UncertaintyTable stated) {
  calib::SensorCalibration sensor;
  sensor.sensor = calib::Sensor::gyro_x;
  sensor.temp_min_c = -10.0;
  sensor.temp_max_c = 40.0;
  sensor.bias = calib::TableCurve{-10.0, 50.0, {0.0, 0.5 * base::kRadPerDeg}};
  for (auto* widths : {&stated.ci95, &stated.pi95}) {
    for (double& width : *widths) width *= base::kRadPerDeg;
  }
  sensor.bias_uncertainty = std::move(stated);
  return sensor;
}

calib::Calibration calibration_of(std::vector<calib::SensorCalibration> sensors) {
  calib::Calibration calibration;
  calibration.gravity_mps2 = 9.80665;
  calibration.sensors = std::move(sensors);
  return calibration;
}

TEST(FreeInertial, HalfADegreeASecondIs385MetresAfter30SecondsAndWhatIsLeftIsTheSumOfBothEnds) {
  const json impact = impact_json(calibration_of({gyro({{-10.0, 40.0}, {0.0001, 0.0001}, {0.002, 0.003}})}));
  const json& sensor = impact["free_inertial"][0];
  EXPECT_NEAR(sensor["change"].get<double>(), 0.5, 1e-12);
  // [AH05 §6.4.3] about 385 m and 3.1 km.
  EXPECT_NEAR(sensor["after_30_s_m"]["without"].get<double>(), 385.0, 0.5);
  EXPECT_NEAR(sensor["after_60_s_m"]["without"].get<double>(), 3080.0, 5.0);
  EXPECT_NEAR(sensor["left"].get<double>(), 0.005, 1e-12);
  EXPECT_NEAR(sensor["after_30_s_m"]["with"].get<double>(), 3.85, 0.005);
  EXPECT_TRUE(impact["warnings"].empty());
}

TEST(FreeInertial, ACalibrationWithoutUncertaintyClaimsNothingOfWhatIsLeft) {
  const json impact = impact_json(calibration_of({gyro({})}));
  const json& sensor = impact["free_inertial"][0];
  for (const json& unknown : {sensor["left"], sensor["left_interval"], sensor["after_30_s_m"]["with"]}) {
    EXPECT_TRUE(unknown.is_null());
  }
  EXPECT_NEAR(sensor["change"].get<double>(), 0.5, 1e-12);
  EXPECT_TRUE(impact["warnings"].empty());  // not that of a single run
}

TEST(FreeInertial, SensorsWithoutTwoCommonTemperaturesHaveNoImpact) {
  calib::SensorCalibration colder = gyro({});
  colder.temp_max_c = -10.0;
  EXPECT_TRUE(impact_json(calibration_of({gyro({}), colder})).is_null());
  EXPECT_TRUE(impact_json(calibration_of({})).is_null());
}

}  // namespace
}  // namespace soak::station
