// SPDX-License-Identifier: Apache-2.0
// Sensors over thermometers of their own on their way out of the laboratory: file, runtime, exports.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "calib/deploy/calibration_file.h"
#include "calib/deploy/export.h"
#include "calib/deploy/table_form.h"
#include "calib/runtime/soak_terms.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/loaded_file.h"
#include "tests/errors.h"

namespace soak::calib {
namespace {

using samples::get;
using samples::golden_fis;
using samples::golden_thermometers;
using samples::head_of;
using samples::Loaded;
using Six = std::array<float, 6>;

constexpr Six kSixReadings = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};
constexpr std::uint16_t kThermometers = 0x0024;

TEST(Thermometers, ReadersThatDoNotKnowThemRefuseTheFile) {
  base::Bytes bytes = *encode(golden_thermometers());
  EXPECT_EQ(get<std::uint16_t>(bytes, 10), 4) << "minor version";
  const std::size_t head = head_of(bytes, kThermometers);
  ASSERT_GT(head, 0U);
  EXPECT_EQ(bytes[head + 3], 1) << "critical";
  EXPECT_EQ(head_of(*encode(golden_fis()), kThermometers), 0U) << "a file of the unit's thermometer needs no 1.4";
}

TEST(Thermometers, ComeBackFromTheFile) {
  const auto read = decode(*encode(golden_thermometers()));
  ASSERT_TRUE(read) << read.error().message;
  for (const SensorCalibration& sensor : read->sensors) {
    const bool own = sensor.sensor == Sensor::gyro_x || sensor.sensor == Sensor::accel_z;
    EXPECT_EQ(sensor.own_thermometer, own) << name_of(sensor.sensor);
  }
}

TEST(Thermometers, TwoSectionsOrOneOfAnotherLengthAreRefused) {
  const base::Bytes good = *encode(golden_thermometers());
  soak_cal cal;
  base::Bytes twice = good;
  samples::append_section(twice, kThermometers, 1, true, {1, 0, 0, 0});
  EXPECT_EQ(soak_load(&cal, twice.data(), twice.size()), SOAK_E_FORMAT);
  base::Bytes longer = *encode(golden_fis());
  samples::append_section(longer, kThermometers, 1, true, {1, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(soak_load(&cal, longer.data(), longer.size()), SOAK_E_FORMAT);
  base::Bytes newer = *encode(golden_fis());
  samples::append_section(newer, kThermometers, 2, true, {1, 0, 0, 0});
  EXPECT_EQ(soak_load(&cal, newer.data(), newer.size()), SOAK_E_UNKNOWN);
}

TEST(Thermometers, OneTemperatureLeavesTheirSensorsRawAndCannotBeMissed) {
  const Loaded file(golden_thermometers());
  const Loaded plain(golden_fis());
  Six out{};
  Six expected{};
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply(&file.cal, 20.0F, kSixReadings.data(), out.data(), &flags), SOAK_INVALID);
  EXPECT_EQ(flags, SOAK_FLAG_THERMOMETER | SOAK_FLAG_INVALID(0U) | SOAK_FLAG_INVALID(5U));
  ASSERT_EQ(soak_apply(&plain.cal, 20.0F, kSixReadings.data(), expected.data(), &flags), SOAK_OK);
  for (std::size_t i = 0; i < 6; ++i) {
    if (i == 0 || i == 5) {
      EXPECT_EQ(out[i], kSixReadings[i]) << i;
    } else {
      EXPECT_FLOAT_EQ(out[i], expected[i]) << i;  // the three accelerometers share a determinant
    }
  }
}

TEST(Thermometers, EachSensorIsCorrectedAtItsOwnTemperature) {
  const Loaded file(golden_thermometers());
  const Loaded plain(golden_fis());
  const Six temps_c = {33.0F, 25.0F, 25.0F, 25.0F, 25.0F, 11.5F};
  Six out{};
  std::uint32_t flags = 0;
  ASSERT_EQ(soak_apply_temps(&file.cal, temps_c.data(), kSixReadings.data(), out.data(), &flags), SOAK_OK);
  EXPECT_EQ(flags, 0U);
  for (std::size_t i = 0; i < 6; ++i) {
    Six at_one{};
    ASSERT_EQ(soak_apply(&plain.cal, temps_c[i], kSixReadings.data(), at_one.data(), &flags), SOAK_OK);
    EXPECT_FLOAT_EQ(out[i], at_one[i]) << i;  // without couplings a sensor knows its own temperature alone
  }
}

TEST(Thermometers, OneOutOfRangeOrUnknownConcernsItsSensorAlone) {
  const Loaded file(golden_thermometers());
  Six temps_c = {20.0F, 20.0F, 20.0F, 20.0F, 20.0F, 70.5F};
  Six out{};
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply_temps(&file.cal, temps_c.data(), kSixReadings.data(), out.data(), &flags), SOAK_CLAMPED);
  EXPECT_EQ(flags, SOAK_FLAG_CLAMPED(5U));
  temps_c[5] = NAN;
  EXPECT_EQ(soak_apply_temps(&file.cal, temps_c.data(), kSixReadings.data(), out.data(), &flags), SOAK_INVALID);
  EXPECT_EQ(flags, SOAK_FLAG_INVALID(5U));
  EXPECT_EQ(out[5], kSixReadings[5]);
}

TEST(Thermometers, TemperaturesThatMoveAreNotTakenForTheirs) {
  const Loaded file(golden_thermometers());
  soak_terms terms;
  ASSERT_EQ(soak_load_terms(&terms, &file.cal), SOAK_ABSENT);
  Six out{};
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply_moving(&file.cal, &terms, 20.0F, 0.01F, kSixReadings.data(), out.data(), &flags), SOAK_INVALID);
  EXPECT_NE(flags & SOAK_FLAG_THERMOMETER, 0U);
  EXPECT_EQ(out[0], kSixReadings[0]);
}

TEST(Thermometers, RuntimeSaysWhichSensorsHaveOne) {
  const Loaded file(golden_thermometers());
  for (int i = 0; i < 6; ++i) EXPECT_EQ(soak_has_own_thermometer(&file.cal, i), i == 0 || i == 5 ? 1 : 0);
  EXPECT_EQ(soak_has_own_thermometer(&file.cal, 6), 0);
  EXPECT_EQ(soak_has_own_thermometer(nullptr, 0), 0);
}

TEST(Thermometers, TableFormKeepsThem) {
  const auto table = table_form(golden_thermometers(), 101);
  ASSERT_TRUE(table);
  EXPECT_TRUE(table->sensors[0].own_thermometer);
}

TEST(Thermometers, AutopilotsThatHaveOneAreNotServedAndTheMessageSaysWhy) {
  for (const bool gyro : {true, false}) {
    Calibration calibration = golden_fis();
    calibration.sensors[gyro ? 1U : 4U].own_thermometer = true;
    const auto px4 = export_px4(calibration, {});
    const auto ardupilot = export_ardupilot(calibration, {});
    const char* sensor = gyro ? "gyro_y" : "accel_y";
    EXPECT_TRUE(is_bad_input(px4, {sensor, "PX4"}));
    EXPECT_TRUE(is_bad_input(ardupilot, {sensor, "ArduPilot"}));
  }
}

TEST(Thermometers, CHeaderAndJsonSayIt) {
  const std::string header = *export_c(golden_thermometers());
  EXPECT_NE(header.find("gyro_x: anfis, valid from -30 to 70 degC, scale unknown, over a thermometer of its own"),
            std::string::npos);
  EXPECT_NE(header.find("soak_apply_temps(&cal, temps_c"), std::string::npos);
  EXPECT_EQ(export_c(golden_fis())->find("thermometer"), std::string::npos);
  const auto document = nlohmann::json::parse(*export_json(golden_thermometers()));
  EXPECT_EQ(document["sensors"]["gyro_x"]["thermometer"], "own");
  EXPECT_EQ(document["sensors"]["gyro_y"]["thermometer"], "unit");
}

}  // namespace
}  // namespace soak::calib
