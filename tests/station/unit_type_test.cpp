// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/units.h"
#include "station/config/unit_type_file.h"

namespace soak::station {
namespace {

const std::filesystem::path kUnits = std::filesystem::path(SOAK_TEST_FOLDER).parent_path() / "procedures" / "units";

TEST(UnitTypeFile, EveryFieldIsRead) {
  const auto type = parse_unit_type(R"(name = "x1"
description = "made up"
sign_at_rest = -1
warm_up_s = 30
axes = ["-Y", "+X", "+Z"]
[rating]
temp_min_c = -40
temp_max_c = 85
[gyro]
range_dps = 450
lsb_dps = 0.01
noise_max_dps_rthz = 0.02
bias_max_dps = 1.5
[accel]
range_mps2 = 50
lsb_mps2 = 0.002
noise_max_mps2_rthz = 0.003
bias_max_mps2 = 0.4
[thermometers]
kind = "per_sensor"
lsb_c = 0.0625
repeatability_c = 0.125
[limits]
gyro = 0.1
gyro_y = 0.2
accel_z = 0.3
accel_scale_ppm = 400
accel_x_scale_ppm = 500
)",
                                    "units/x1.toml");
  ASSERT_TRUE(type) << type.error().message;
  EXPECT_EQ(type->name, "x1");
  EXPECT_EQ(type->description, "made up");
  EXPECT_EQ(type->sign_at_rest, -1);
  EXPECT_EQ(type->warm_up_s, 30.0);
  EXPECT_EQ(type->axes, (std::array<std::string, 3>{"-Y", "+X", "+Z"}));
  EXPECT_EQ(type->temp_min_c, -40.0);
  EXPECT_EQ(type->temp_max_c, 85.0);
  EXPECT_EQ(type->gyro_range_dps, 450.0);
  EXPECT_EQ(type->gyro_lsb_dps, 0.01);
  EXPECT_EQ(type->gyro_noise_max_dps_rthz, 0.02);
  EXPECT_EQ(type->gyro_bias_max_dps, 1.5);
  EXPECT_EQ(type->accel_range_mps2, 50.0);
  EXPECT_EQ(type->accel_lsb_mps2, 0.002);
  EXPECT_EQ(type->accel_noise_max_mps2_rthz, 0.003);
  EXPECT_EQ(type->accel_bias_max_mps2, 0.4);
  EXPECT_EQ(type->thermometers, calib::Thermometers::per_sensor);
  EXPECT_EQ(type->temp_lsb_c, 0.0625);
  EXPECT_EQ(type->temp_repeatability_c, 0.125);
  const double deg = base::kRadPerDeg;
  EXPECT_NEAR(*type->limits[0], 0.1 * deg, 1e-15);
  EXPECT_NEAR(*type->limits[1], 0.2 * deg, 1e-15);
  EXPECT_FALSE(type->limits[3] || type->limits[4]);
  EXPECT_EQ(type->limits[5], 0.3);
  EXPECT_EQ(type->limits.scale_ppm, (std::array<std::optional<double>, 6>{{{}, {}, {}, 500.0, 400.0, 400.0}}));
}

TEST(UnitTypeFile, WhatIsNotSaidIsAbsent) {
  const auto type = parse_unit_type("name = \"x1\"\n", "x1.toml");
  ASSERT_TRUE(type);
  EXPECT_EQ(type->sign_at_rest, 1);
  EXPECT_FALSE(type->temp_min_c || type->temp_max_c || type->gyro_range_dps || type->accel_range_mps2 ||
               type->gyro_lsb_dps || type->accel_lsb_mps2 || type->warm_up_s || type->temp_lsb_c ||
               type->gyro_noise_max_dps_rthz || type->accel_noise_max_mps2_rthz || type->gyro_bias_max_dps ||
               type->accel_bias_max_mps2);
  EXPECT_FALSE(type->axes || type->thermometers);
  EXPECT_EQ(type->limits, calib::Limits{});
}

TEST(UnitTypeFile, EveryMistakeIsReportedWithItsLine) {
  const auto type = parse_unit_type(
      "name = \"other\"\nsign_at_rest = 0\naxes = [\"+Y\", \"+X\", \"+Z\"]\n[rating]\ntemp_min_c = 85\ntemp_max_c = "
      "-40\n"
      "[gyro]\nrange_dps = -1\ncolour = 3\n[accel]\nrange_mps2 = \"big\"\n",
      "x1.toml");
  ASSERT_FALSE(type);
  for (const int line : {1, 2, 3, 6, 8, 9, 11}) {
    EXPECT_NE(type.error().message.find(fmt::format("x1.toml:{}: ", line)), std::string::npos)
        << line << type.error().message;
  }
}

TEST(UnitTypeFile, HalfARatingIsNone) {
  const auto type = parse_unit_type("name = \"x1\"\n[rating]\ntemp_min_c = -40\n", "x1.toml");
  ASSERT_FALSE(type);
  EXPECT_NE(type.error().message.find("'rating.temp_max_c'"), std::string::npos) << type.error().message;
}

TEST(UnitTypeFile, ShippedTypesAreReadInTheOrderOfTheirNames) {
  const auto types = read_unit_types(kUnits);
  ASSERT_TRUE(types) << types.error().where << types.error().message;
  std::vector<std::string> names;
  for (const auto& type : *types) names.push_back(type.name);
  EXPECT_EQ(names, (std::vector<std::string>{"ahrs400", "generic", "mti-300", "vn-200"}));
  const calib::UnitType& mti = types->back();
  EXPECT_EQ(mti.temp_min_c, -40.0);
  EXPECT_EQ(mti.temp_max_c, 85.0);
  EXPECT_FALSE(types->at(1).temp_min_c) << "the limits of a generic unit are unknown";
}

TEST(UnitTypeFile, AWrongFileSpoilsTheFolderAndAMissingFolderIsRefused) {
  char name[] = "/tmp/soak-types-XXXXXX";
  const std::filesystem::path folder = mkdtemp(name);
  std::ofstream(folder / "a.toml") << "name = \"a\"\n";
  std::ofstream(folder / "notes.txt") << "not a type";
  EXPECT_EQ(read_unit_types(folder)->size(), 1u);
  std::ofstream(folder / "b.toml") << "name = \"b\"\nwheels = 4\n";
  const auto types = read_unit_types(folder);
  ASSERT_FALSE(types);
  EXPECT_EQ(types.error().where, (folder / "b.toml").string() + ":2");
  std::filesystem::remove_all(folder);
  EXPECT_FALSE(read_unit_types(folder));
}

}  // namespace
}  // namespace soak::station
