// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/unit/simulated_unit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;

/// Span over −30 ... +70 °C, on a grid of the test's own, in deg/s or m/s².
double span_on_fine_grid(const SimulatedUnit& unit, Sensor sensor) {
  double least = 1e9;
  double greatest = -1e9;
  for (int i = 0; i <= 10000; ++i) {
    const double value =
        unit.sensors[calib::index_of(sensor)].bias.at(-30.0 + 0.01 * i) * calib::printed_per_si(sensor);
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  return greatest - least;
}

TEST(SimulatedUnit, HasTheSpanOfDriftThatTheFieldKnowsOnEverySensor) {
  CampaignConfig config = test::shipped_config();
  for (config.seed = 0; config.seed < 20; ++config.seed) {
    for (int number = 1; number <= 3; ++number) {
      const SimulatedUnit unit = draw_unit(config, number);
      for (const Sensor sensor : calib::kSensors) {
        const double nominal = calib::is_gyro(sensor) ? 0.5 : 0.3;
        EXPECT_NEAR(span_on_fine_grid(unit, sensor), nominal, 0.3 * nominal)
            << unit.serial << " seed " << config.seed << " " << calib::name_of(sensor);
      }
    }
  }
}

TEST(SimulatedUnit, HasOneOrTwoSuddenFeaturesPerGyro) {
  const CampaignConfig config = test::shipped_config();
  std::array<int, 3> gyros_with{};
  for (int number = 1; number <= 40; ++number) {
    const SimulatedUnit unit = draw_unit(config, number);
    for (std::size_t gyro = 0; gyro < 3; ++gyro) {
      const auto& features = unit.sensors[gyro].bias.features();
      ASSERT_GE(features.size(), 1U);
      ASSERT_LE(features.size(), 2U);
      ++gyros_with[features.size()];
      for (const ThermalCurve::Feature& feature : features) {
        EXPECT_NEAR(std::abs(feature.height) * base::kDegPerRad, 0.1, 0.0101);
        EXPECT_NEAR(feature.sigma_c, 7.5, 1.5);
      }
    }
  }
  // Of 120 fair choices fewer than 35 one way have a probability below 1e-5.
  EXPECT_GE(gyros_with[1], 35);
  EXPECT_GE(gyros_with[2], 35);
}

TEST(SimulatedUnit, LetsTheAccelerometerScaleVaryByAThousandPpmOrSo) {
  const CampaignConfig config = test::shipped_config();
  for (int number = 1; number <= 20; ++number) {
    const SimulatedUnit unit = draw_unit(config, number);
    for (const Sensor sensor : calib::kSensors) {
      std::vector<double> scale_ppm;
      for (int temp_c = -30; temp_c <= 70; ++temp_c) {
        scale_ppm.push_back(unit.sensors[calib::index_of(sensor)].scale_ppm.at(temp_c));
      }
      const double span_ppm = span_of(scale_ppm);
      EXPECT_GE(span_ppm, calib::is_gyro(sensor) ? 0.0 : 790.0);
      EXPECT_LE(span_ppm, calib::is_gyro(sensor) ? 0.0 : 1510.0);
    }
  }
}

TEST(SimulatedUnit, StartsWithAnotherOffsetAtEachPowerOn) {
  CampaignConfig config = test::shipped_config();
  std::vector<double> gyro_dps;
  std::vector<double> accel_mps2;
  for (int number = 1; number <= 200; ++number) {
    const SimulatedUnit unit = draw_unit(config, number);
    for (int run = kVerificationRun; run <= 4; ++run) {
      for (const Sensor sensor : calib::kSensors) {
        const double offset = power_on_offset(config, unit, run, sensor) * calib::printed_per_si(sensor);
        (calib::is_gyro(sensor) ? gyro_dps : accel_mps2).push_back(offset);
      }
    }
  }
  // 3,000 draws each: the RMS has a relative standard error of 1.3 %, the mean one of sigma/55.
  EXPECT_NEAR(test::rms_of(gyro_dps), 0.02, 4 * 0.013 * 0.02);
  EXPECT_NEAR(test::rms_of(accel_mps2), 0.01, 4 * 0.013 * 0.01);
  EXPECT_NEAR(test::mean_of(gyro_dps), 0.0, 4 * 0.02 / 55);
  EXPECT_NEAR(test::mean_of(accel_mps2), 0.0, 4 * 0.01 / 55);
}

TEST(SimulatedUnit, ReadsGravityTimesScalePlusBiasOnTheAxisThatPointsUp) {
  const CampaignConfig config = test::shipped_config();
  const SimulatedUnit unit = draw_unit(config, 1);
  const SimulatedSensor& z = unit.sensors[calib::index_of(Sensor::accel_z)];
  const double up = ideal_reading(unit, Sensor::accel_z, 40.0, {0.0, 0.0, 9.80665}, {});
  const double down = ideal_reading(unit, Sensor::accel_z, 40.0, {0.0, 0.0, -9.80665}, {});
  EXPECT_NEAR((up + down) / 2, z.bias.at(40.0), 1e-12);
  EXPECT_NEAR(((up - down) / 2 / 9.80665 - 1) * 1e6, z.scale_ppm.at(40.0), 1e-6);
  EXPECT_NEAR(up, 9.8, 0.5);
}

TEST(SimulatedUnit, DependsOnItsNumberAndTheSeedAlone) {
  CampaignConfig config = test::shipped_config();
  const double bias = draw_unit(config, 2).sensors[0].bias.at(10.0);
  config.units = 17;
  config.runs = 9;
  EXPECT_EQ(draw_unit(config, 2).sensors[0].bias.at(10.0), bias);
  EXPECT_NE(draw_unit(config, 3).sensors[0].bias.at(10.0), bias);
  ++config.seed;
  EXPECT_NE(draw_unit(config, 2).sensors[0].bias.at(10.0), bias);
}

}  // namespace
}  // namespace soak::hal::sim
