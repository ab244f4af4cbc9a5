// SPDX-License-Identifier: Apache-2.0
#include "station/import/columns_map.h"

#include <gtest/gtest.h>

#include <cmath>

namespace soak::station {
namespace {

TEST(ColumnsMap, ReadsEveryKey) {
  const auto map = parse_columns_map(R"(
separator = "tab"
skip_rows = 2
[columns]
"Gyro.X" = { as = "gx_rps", type = "i16", scale = 0.001, offset = 5 }
Temp = "temp_k"
note = { type = "label" }
[constants]
phase = "ramp"
plateau_c = 25
[positions]
tilt = [0, 3, 4]
left = { up = [0, 0, 2], rate_dps = 30 }
north = { up = [0, 0, 1], azimuth_deg = -15.5 }
[azimuths_deg]
"-x" = 90
)",
                                     "m.toml");
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->separator, '\t');
  EXPECT_EQ(map->skip_rows, 2U);
  ASSERT_EQ(map->columns.size(), 3U);
  const MappedColumn& gyro = map->columns[0];
  EXPECT_EQ(gyro.source, "Gyro.X");
  EXPECT_EQ(gyro.meaning.name, "gyro_x");
  EXPECT_EQ(gyro.meaning.unit, "rps");
  EXPECT_EQ(gyro.type, db::SampleType::i16);
  EXPECT_EQ(gyro.scale, 0.001);
  EXPECT_EQ(gyro.offset, 5.0);
  EXPECT_EQ(map->columns[1].meaning.unit, "k");
  EXPECT_TRUE(map->columns[2].is_label);
  EXPECT_EQ(map->constants, (std::vector<std::pair<std::string, std::string>>{{"phase", "ramp"}, {"plateau_c", "25"}}));
  ASSERT_EQ(map->positions.size(), 4U);
  calib::Position named = *calib::position_named("-X");
  named.azimuth_deg = 90.0;
  EXPECT_EQ(map->positions[0], named);
  EXPECT_EQ(map->positions[1].label, "left");
  EXPECT_EQ(map->positions[1].up, (calib::Vector3{0.0, 0.0, 1.0}));
  EXPECT_EQ(map->positions[1].rate_dps, 30.0);
  EXPECT_EQ(map->positions[2].azimuth_deg, -15.5);
  EXPECT_FALSE(map->positions[2].rate_dps);
  EXPECT_EQ(map->positions[3].up, (calib::Vector3{0.0, 0.6, 0.8}));
  EXPECT_FALSE(map->positions[3].rate_dps || map->positions[3].azimuth_deg);
}

TEST(ColumnsMap, ReportsEveryMistakeWithItsLine) {
  const auto map = parse_columns_map(
      "separator = \"ab\"\n"
      "skip_rows = -1\n"
      "decimal = \",\"\n"
      "[columns]\n"
      "a = \"gx_degs\"\n"
      "b = { as = \"temp_c\", type = \"i24\" }\n"
      "c = { as = \"ax_g\", scale = 0 }\n"
      "d = { as = \"ay_g\", factor = 2 }\n"
      "e = 5\n"
      "f = { as = \"phase\", scale = 2 }\n"
      "g = { as = \"ay_g\" }\n"
      "h = { as = \"run\", type = \"i8\" }\n"
      "i = { as = \"t_s\", scale = -1 }\n"
      "j = { as = \"az_g\", offset = nan }\n"
      "[positions]\n"
      "P1 = [0, 0]\n"
      "\"+X\" = [1, 0.05, 0]\n"
      "P2 = [0, 0, 0]\n"
      "[constants]\n"
      "t_s = 1\n"
      "[positions.P3]\n"
      "rate_dps = 5\n"
      "[positions.P4]\n"
      "up = [0, 0, 1]\n"
      "rate_dps = nan\n"
      "rate_rps = 1\n"
      "[positions.P5]\n"
      "up = [0, 0, 1]\n"
      "rate_dps = -20001\n"
      "[azimuths_deg]\n"
      "P1 = 3\n"
      "\"+Y\" = \"north\"\n"
      "\"+Z\" = 361\n"
      "\"+x\" = 5\n"
      "\"+X\" = 5\n",
      "m.toml");
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(map.error().where, "m.toml");
  for (const int line : {1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 16, 17, 18, 20, 21, 25, 26, 29, 31, 32, 33, 34}) {
    EXPECT_NE(("\n" + map.error().message).find("\nm.toml:" + std::to_string(line) + ": "), std::string::npos)
        << "line " << line << " in\n"
        << map.error().message;
  }
}

TEST(ColumnsMap, ReportsTheFirstSyntaxErrorWithItsLine) {
  const auto map = parse_columns_map("skip_rows = 1\n[columns\n", "m.toml");
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().where, "m.toml:2") << map.error().message;
}

TEST(ColumnsMap, WritesTextThatItReadsBackToTheLastBit) {
  const auto map = parse_columns_map(R"(
separator = ";"
skip_rows = 1
[columns]
"a\"b\\c" = { as = "gx_dps", type = "f32", scale = 0.1, offset = -1e-300 }
"t" = { as = "t_us", type = "i64", offset = -256551281997598 }
"text" = { as = "text", type = "u16", labels = ["x, y", "\u0007\"z\""] }
[positions]
P1 = [1, 1, 1]
P2 = { up = [1, 2, 3], rate_dps = -0.1 }
P3 = { up = [0, 0, 1], rate_dps = 1e-300 }
P4 = { up = [0, 0, 1], rate_dps = 1, azimuth_deg = 0.1 }
"+Y" = [0.0002, 1, -0.0001]
"-X" = { up = [-1, 0.0005, 0], azimuth_deg = 12.5 }
[azimuths_deg]
"+X" = 0
"-Z" = -359.9
)",
                                     "m.toml");
  ASSERT_TRUE(map) << map.error().message;
  const auto again = parse_columns_map(columns_map_text(*map), "again.toml");
  ASSERT_TRUE(again) << again.error().message << "\n" << columns_map_text(*map);
  EXPECT_EQ(again->separator, map->separator);
  EXPECT_EQ(again->skip_rows, map->skip_rows);
  EXPECT_EQ(again->positions, map->positions);
  ASSERT_EQ(again->columns.size(), map->columns.size());
  for (std::size_t i = 0; i < map->columns.size(); ++i) {
    EXPECT_EQ(again->columns[i].source, map->columns[i].source);
    EXPECT_EQ(again->columns[i].meaning, map->columns[i].meaning);
    EXPECT_EQ(again->columns[i].type, map->columns[i].type);
    EXPECT_EQ(again->columns[i].scale, map->columns[i].scale);
    EXPECT_EQ(again->columns[i].offset, map->columns[i].offset);
    EXPECT_EQ(again->columns[i].labels, map->columns[i].labels);
  }
}

}  // namespace
}  // namespace soak::station
