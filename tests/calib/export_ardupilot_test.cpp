// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/calib/export_cubic_samples.h"

namespace soak::calib {
namespace {

using namespace samples;

using Parameters = std::map<std::string, float>;

Parameters parameters(const std::string& text) {
  Parameters values;
  for (const auto& words : parameter_lines(text)) {
    EXPECT_EQ(words.size(), 2U);
    EXPECT_EQ(words[1].find_first_of("eE"), std::string::npos) << "no exponents: " << words[1];
    EXPECT_LE(words[0].size(), 16U) << "MAVLink's limit";
    EXPECT_TRUE(values.emplace(words[0], std::stof(words[1])).second) << words[0];
  }
  return values;
}

/// ArduPilot's documented correction in float32: raw − p(T) + p(CALTEMP) − OFFS with both temperatures constrained to
/// [TMIN, TMAX], p(T) = (C1 + (C2 + C3 d) d) d · 1e-6, d = T − 35.
struct Imu {
  Parameters p;
  int number = 1;

  [[nodiscard]] float polynomial(const std::string& kind, char axis, float temp_c) const {
    const std::string prefix = "INS_TCAL" + std::to_string(number) + "_";
    const float t = std::min(std::max(temp_c, p.at(prefix + "TMIN")), p.at(prefix + "TMAX"));
    const float d = t - 35.0F;
    const auto c = [&](int k) { return p.at(prefix + kind + std::to_string(k) + "_" + axis); };
    return (c(1) + (c(2) + c(3) * d) * d) * d * 1.0e-6F;
  }
  [[nodiscard]] float corrected(Sensor sensor, float raw, float temp_c, float offset, float caltemp) const {
    const char axis = "XYZ"[axis_of(sensor)];
    const std::string kind = is_gyro(sensor) ? "GYR" : "ACC";
    return raw - polynomial(kind, axis, temp_c) + polynomial(kind, axis, caltemp) - offset;
  }
  /// With the offsets of the file itself.
  [[nodiscard]] float corrected(Sensor sensor, float raw, float temp_c) const {
    const std::string kind = is_gyro(sensor) ? "GYR" : "ACC";
    const std::string n = std::to_string(number);
    const std::string offset = is_gyro(sensor) ? (number == 1 ? "INS_GYROFFS_" : "INS_GYR" + n + "OFFS_")
                                               : "INS_ACC" + (number == 1 ? "" : n) + "OFFS_";
    return corrected(sensor, raw, temp_c, p.at(offset + "XYZ"[axis_of(sensor)]), p.at("INS_" + kind + n + "_CALTEMP"));
  }
};

Curve cubic_curve(Sensor sensor) {
  const double f = 1.0 + static_cast<double>(index_of(sensor));
  return SplineCurve{{-30.0, 70.0}, {{f * 0.01, f * 2e-4, f * -3e-6, f * 4e-8}}};
}

TEST(ExportArduPilot, ACubicModelIsTakenOffWholeAlsoOutsideTheRange) {
  const Calibration calibration = six_sensors(-30.0, 70.0, cubic_curve);
  for (const int instance : {0, 1, 2}) {
    const auto file = export_ardupilot(calibration, {instance});
    ASSERT_TRUE(file) << file.error().message;
    const Imu imu{parameters(file->text), instance + 1};
    for (const SensorCalibration& sensor : calibration.sensors) {
      const double f = 1.0 + static_cast<double>(index_of(sensor.sensor));
      for (double temp_c = -60.0; temp_c <= 100.0; temp_c += 0.7) {
        const double raw = held(sensor.bias, temp_c, -30.0, 70.0);
        // 24 bits of terms up to 0.06 f: 4e-9 f each, and a handful of them.
        EXPECT_NEAR(imu.corrected(sensor.sensor, static_cast<float>(raw), static_cast<float>(temp_c)), 0.0, 2e-8 * f)
            << name_of(sensor.sensor) << ' ' << temp_c;
      }
    }
  }
}

TEST(ExportArduPilot, OffsetsThatTheUserTookAtATemperatureAreLeftAloneThere) {
  // The board's own calibration at 12 °C gave the true bias there; the correction is then that of the model at all
  // others.
  const Calibration calibration = six_sensors(-30.0, 70.0, cubic_curve);
  const Imu imu{parameters(export_ardupilot(calibration, {})->text), 1};
  for (const SensorCalibration& sensor : calibration.sensors) {
    const auto own = static_cast<float>(evaluate(sensor.bias, 12.0));
    // raw − p + p − raw: the first difference is rounded to the raw value's step, 7.5e-9 below 0.125.
    EXPECT_NEAR(imu.corrected(sensor.sensor, own, 12.0F, own, 12.0F), 0.0, 1.5e-8);
    for (const double temp_c : {-30.0, 0.0, 35.0, 70.0}) {
      const auto raw = static_cast<float>(evaluate(sensor.bias, temp_c));
      EXPECT_NEAR(imu.corrected(sensor.sensor, raw, static_cast<float>(temp_c), own, 12.0F), 0.0, 1.5e-7);
    }
  }
}

TEST(ExportArduPilot, LossIsAsStated) {
  const Calibration calibration = golden_fis();
  const auto file = export_ardupilot(calibration, {});
  ASSERT_TRUE(file);
  const Imu imu{parameters(file->text), 1};
  ASSERT_EQ(file->losses.size(), 6U);
  for (const CubicLoss& loss : file->losses) {
    double squares = 0.0;
    double worst = 0.0;
    constexpr int kPoints = 7001;
    for (int i = 0; i < kPoints; ++i) {
      const double temp_c = -30.0 + 100.0 * i / (kPoints - 1);
      const double bias = evaluate(calibration.sensors[index_of(loss.sensor)].bias, temp_c);
      const double left = imu.corrected(loss.sensor, 0.0F, static_cast<float>(temp_c)) + bias;
      squares += left * left;
      worst = std::max(worst, std::abs(left));
    }
    // Two even grids: each end counts as a point and not as half of one, so that misfits of up to 3 rms at both ends
    // make a difference of 9/2001 to the mean square, half of that to the rms. The maximum of a smooth function is met
    // better.
    EXPECT_NEAR(loss.rms, std::sqrt(squares / kPoints), 3e-3 * loss.rms) << name_of(loss.sensor);
    EXPECT_NEAR(loss.worst, worst, 1e-3 * worst) << name_of(loss.sensor);
    EXPECT_EQ(loss.reference_c, 35.0);
  }
}

TEST(ExportArduPilot, OffsetsComeWithTheTemperatureThatTheyHoldFor) {
  const auto warm = parameters(export_ardupilot(golden_fis(), {})->text);
  EXPECT_EQ(warm.at("INS_ACC1_CALTEMP"), 35.0F);
  Calibration cold = golden_fis();
  for (SensorCalibration& sensor : cold.sensors) sensor.temp_max_c = 20.0;
  const auto p = parameters(export_ardupilot(cold, {1})->text);
  EXPECT_EQ(p.at("INS_GYR2_CALTEMP"), 20.0F);  // 35 °C is out of range: its nearer end
  EXPECT_EQ(p.at("INS_TCAL2_TMAX"), 20.0F);
  EXPECT_TRUE(p.contains("INS_ACC2OFFS_Z"));
}

TEST(ExportArduPilot, AccelerometersWithoutALevelGetNoOffsets) {
  const auto file = export_ardupilot(golden_fis(), {0, true});
  const auto p = parameters(file->text);
  EXPECT_FALSE(p.contains("INS_ACCOFFS_X"));
  EXPECT_FALSE(p.contains("INS_ACC1_CALTEMP"));
  EXPECT_TRUE(p.contains("INS_GYROFFS_X"));
  EXPECT_TRUE(p.contains("INS_TCAL1_ACC3_Z"));
}

TEST(ExportArduPilot, NamesAreAllThoseOfOneImuAndNoOthers) {
  // ENABLE, TMIN, TMAX, 18 coefficients, 6 offsets, 2 temperatures.
  EXPECT_EQ(parameters(export_ardupilot(golden_fis(), {2})->text).size(), 29U);
  EXPECT_FALSE(export_ardupilot(golden_fis(), {3}));
}

TEST(ExportArduPilot, AKindWithoutSensorsIsSwitchedOff) {
  Calibration gyros = golden_fis();
  gyros.sensors.resize(3);
  const auto p = parameters(export_ardupilot(gyros, {})->text);
  for (const char* name : {"INS_TCAL1_ACC1_X", "INS_TCAL1_ACC2_Y", "INS_TCAL1_ACC3_Z"}) EXPECT_EQ(p.at(name), 0.0F);
  EXPECT_FALSE(p.contains("INS_ACCOFFS_X"));
  EXPECT_FALSE(export_ardupilot(golden_mixed(), {}));  // no gyro_y
}

}  // namespace
}  // namespace soak::calib
