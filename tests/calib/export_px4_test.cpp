// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/calib/export_cubic_samples.h"

namespace soak::calib {
namespace {

using namespace samples;

/// NAME → value of a .params file; demands the five columns and the type of each parameter.
std::map<std::string, std::string> params(const std::string& text) {
  std::map<std::string, std::string> values;
  for (const auto& words : parameter_lines(text)) {
    EXPECT_EQ(words.size(), 5U);
    EXPECT_EQ(words[0] + words[1], "11");
    const bool whole = words[2].ends_with("_ID") || words[2].ends_with("_ENABLE");
    EXPECT_EQ(words[4], whole ? "6" : "9") << words[2];
    EXPECT_LT(words[2].size(), 16U) << "PX4 builds names in 16 bytes";
    EXPECT_TRUE(values.emplace(words[2], words[3]).second) << words[2];
  }
  return values;
}

/// The offset as PX4's documentation gives it, in float32: the temperature clipped to TMIN ... TMAX, then
/// X0 + X1 d + X2 d^2 + X3 d^3 with d = T - TREF. Subtracted from the raw value.
float px4_offset(const std::map<std::string, std::string>& p, const std::string& prefix, int axis, float temp_c) {
  const auto f = [&](const std::string& name) { return std::stof(p.at(prefix + name)); };
  const float t = std::min(std::max(temp_c, f("_TMIN")), f("_TMAX"));
  const float d = t - f("_TREF");
  const float d2 = d * d;
  const float d3 = d2 * d;
  const auto x = [&](int power) { return f("_X" + std::to_string(power) + "_" + std::to_string(axis)); };
  return x(0) + x(1) * d + x(2) * d2 + x(3) * d3;
}

std::string prefix_of(Sensor sensor, int instance) {
  return std::string(is_gyro(sensor) ? "TC_G" : "TC_A") + std::to_string(instance);
}

TEST(ExportPx4, ACubicModelComesBackAsItselfAlsoOutsideTheRange) {
  // 0.01 + 2e-4 d - 3e-6 d² + 4e-8 d³, d = T + 30, scaled per sensor: 24 bits of the largest term (0.04) are 2.4e-9.
  const auto bias = [](Sensor sensor) {
    const double f = 1.0 + static_cast<double>(index_of(sensor));
    return SplineCurve{{-30.0, 70.0}, {{f * 0.01, f * 2e-4, f * -3e-6, f * 4e-8}}};
  };
  const Calibration calibration = six_sensors(-30.0, 70.0, bias);
  const auto file = export_px4(calibration, {});
  ASSERT_TRUE(file) << file.error().message;
  const auto p = params(file->text);
  for (const SensorCalibration& sensor : calibration.sensors) {
    const double f = 1.0 + static_cast<double>(index_of(sensor.sensor));
    for (double temp_c = -60.0; temp_c <= 100.0; temp_c += 0.7) {
      EXPECT_NEAR(px4_offset(p, prefix_of(sensor.sensor, 0), static_cast<int>(axis_of(sensor.sensor)),
                             static_cast<float>(temp_c)),
                  held(sensor.bias, temp_c, -30.0, 70.0), 1e-8 * f)
          << name_of(sensor.sensor) << ' ' << temp_c;
    }
  }
  for (const CubicLoss& loss : file->losses) EXPECT_LT(loss.worst, 6e-8);
}

TEST(ExportPx4, LossIsAsStated) {
  const Calibration calibration = golden_fis();
  const auto file = export_px4(calibration, {2, 11, 22});
  ASSERT_TRUE(file);
  const auto p = params(file->text);
  ASSERT_EQ(file->losses.size(), 6U);
  for (const CubicLoss& loss : file->losses) {
    const SensorCalibration& sensor = calibration.sensors[index_of(loss.sensor)];
    double squares = 0.0;
    double worst = 0.0;
    constexpr int kPoints = 7001;
    for (int i = 0; i < kPoints; ++i) {
      const double temp_c = -30.0 + 100.0 * i / (kPoints - 1);
      const auto t = static_cast<float>(temp_c);
      const double difference = px4_offset(p, prefix_of(loss.sensor, 2), static_cast<int>(axis_of(loss.sensor)), t) -
                                evaluate(sensor.bias, temp_c);
      squares += difference * difference;
      worst = std::max(worst, std::abs(difference));
    }
    // Two even grids: each end counts as a point and not as half of one, so that misfits of up to 3 rms at both ends
    // make a difference of 9/2001 to the mean square, half of that to the rms. The maximum of a smooth function is met
    // better.
    EXPECT_NEAR(loss.rms, std::sqrt(squares / kPoints), 3e-3 * loss.rms) << name_of(loss.sensor);
    EXPECT_NEAR(loss.worst, worst, 1e-3 * worst) << name_of(loss.sensor);
    EXPECT_GT(loss.rms, 0.0);
    EXPECT_EQ(loss.reference_c, 20.0);
  }
}

TEST(ExportPx4, NamesAreThoseOfTheInstanceAndNoOthers) {
  const auto p = params(export_px4(golden_fis(), {3, 1310988, 1311244})->text);
  // Per kind: enable, id, 12 coefficients, TREF, TMIN, TMAX.
  EXPECT_EQ(p.size(), 34U);
  EXPECT_EQ(p.at("TC_A3_ID"), "1310988");
  EXPECT_EQ(p.at("TC_G3_ID"), "1311244");
  EXPECT_EQ(p.at("TC_A_ENABLE"), "1");
  EXPECT_EQ(p.at("TC_G3_TREF"), "20");
  EXPECT_EQ(p.at("TC_A3_TMIN"), "-30");
  EXPECT_TRUE(p.contains("TC_G3_X0_2") && p.contains("TC_A3_X3_0"));
  EXPECT_FALSE(export_px4(golden_fis(), {4}));
  EXPECT_FALSE(export_px4(golden_fis(), {-1}));
}

TEST(ExportPx4, WithoutADeviceIdTheIdIsLeftOutAndTheFileSaysSo) {
  const auto file = export_px4(golden_fis(), {});
  EXPECT_FALSE(params(file->text).contains("TC_A0_ID"));
  EXPECT_NE(file->text.find("CAL_ACCn_ID"), std::string::npos);
  EXPECT_EQ(export_px4(golden_fis(), {0, 1, 1})->text.find("CAL_ACCn_ID"), std::string::npos);
}

TEST(ExportPx4, RangeIsThatInWhichAllThreeAxesOfAKindAreValid) {
  Calibration calibration = golden_fis();
  calibration.sensors[1].temp_min_c = -10.0;
  calibration.sensors[2].temp_max_c = 50.0;
  const auto p = params(export_px4(calibration, {})->text);
  EXPECT_EQ(p.at("TC_G0_TMIN") + " " + p.at("TC_G0_TMAX") + " " + p.at("TC_G0_TREF"), "-10 50 20");
  EXPECT_EQ(p.at("TC_A0_TMIN") + " " + p.at("TC_A0_TMAX"), "-30 70");
  calibration.sensors[1].temp_min_c = 50.0;
  const auto none = export_px4(calibration, {});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, base::ErrorKind::bad_input);
}

TEST(ExportPx4, AKindIsExportedWholeOrNotAtAll) {
  const auto missing = export_px4(golden_mixed(), {});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, base::ErrorKind::bad_input);
  Calibration accels = golden_fis();
  accels.sensors.erase(accels.sensors.begin(), accels.sensors.begin() + 3);
  const auto file = export_px4(accels, {});
  ASSERT_TRUE(file);
  EXPECT_FALSE(params(file->text).contains("TC_G_ENABLE"));
  EXPECT_EQ(file->losses.size(), 3U);
  accels.sensors.clear();
  EXPECT_FALSE(export_px4(accels, {}));
}

TEST(ExportPx4, CommentsSayWhereTheNumbersComeFromAndWhatTheyLose) {
  Calibration calibration = golden_fis();
  calibration.simulated = true;
  calibration.unit = "SN\n1\t1\tTC_A_ENABLE\t7\t6";
  const auto file = export_px4(calibration, {});
  for (const char* part : {"SIMULATED", "model version: 7", "created: 2026-11-21T08:00:00Z", "gravity: 9.8123 m/s2",
                           "run: e3b0c44298fc", "gyro_x: rms ", "accel_x: scale factor error from "}) {
    EXPECT_NE(file->text.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(params(file->text).at("TC_A_ENABLE"), "1");
  EXPECT_EQ(export_px4(golden_fis(), {})->text.find("SIMULATED"), std::string::npos);
}

}  // namespace
}  // namespace soak::calib
