// SPDX-License-Identifier: Apache-2.0
#include "station/import/channel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "station/import/slow_channel.h"
#include "station/runs/recording_reader.h"

namespace soak::station {
namespace {

TEST(ChannelUnits, ConvertByTheirDefinitions) {
  EXPECT_DOUBLE_EQ(conversion_to_si("dps")(180.0), M_PI);
  EXPECT_DOUBLE_EQ(conversion_to_si("degph")(3600.0 * 180.0), M_PI);
  EXPECT_EQ(conversion_to_si("rps")(0.1), 0.1);
  EXPECT_EQ(conversion_to_si("g")(1.0), 9.80665);
  EXPECT_DOUBLE_EQ(conversion_to_si("mg")(1000.0), 9.80665);
  EXPECT_DOUBLE_EQ(conversion_to_si("k")(273.15), 0.0);
  EXPECT_DOUBLE_EQ(conversion_to_si("f")(-40.0), -40.0);
  EXPECT_DOUBLE_EQ(conversion_to_si("f")(212.0), 100.0);
  EXPECT_EQ(conversion_to_csv("dps")(0.1), 0.1);
  EXPECT_DOUBLE_EQ(conversion_to_csv("rps")(M_PI), 180.0);
  EXPECT_DOUBLE_EQ(conversion_to_csv("degph")(3600.0), 1.0);
}

TEST(HeaderName, CanonicalHeadersReadBackAsTheirChannel) {
  for (const char* name : {"gyro_x", "gyro_z", "accel_y", "temp_c", "temp_ax_c", "chamber_c", "plateau_c", "utc_s"}) {
    const auto meaning = meaning_of_header(canonical_header(name));
    ASSERT_TRUE(meaning);
    EXPECT_EQ(meaning->name, name);
    EXPECT_NE(meaning->role, ColumnRole::auxiliary);
  }
  EXPECT_EQ(meaning_of_header("temp_board_c")->role, ColumnRole::auxiliary);
  EXPECT_EQ(meaning_of_header("gain")->role, ColumnRole::auxiliary);
}

constexpr double kNone = NAN;

void expect_same(const std::vector<double>& values, const std::vector<double>& expected) {
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_TRUE(values[i] == expected[i] || (std::isnan(values[i]) && std::isnan(expected[i])))
        << i << ": " << values[i];
  }
}

TEST(SlowChannel, HoldsForTwoSecondsAtMost) {
  const std::vector<double> t_s = {0, 1, 2, 3, 3.5, 4, 5, 6, 7};
  std::vector<double> values = {kNone, 10, kNone, kNone, 11, kNone, 12, kNone, kNone};
  hold_slow_channel(t_s, values);
  expect_same(values, {kNone, 10, 10, 10, 11, 11, 12, 12, 12});
  std::vector<double> once = {5, kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone};
  hold_slow_channel(t_s, once);
  expect_same(once, {5, 5, 5, kNone, kNone, kNone, kNone, kNone, kNone});
}

TEST(SlowChannel, HoldsLongerWhereItsOwnSpacingIsLonger) {
  std::vector<double> t_s;
  std::vector<double> values;
  for (int i = 0; i < 60; ++i) {
    t_s.push_back(i);
    values.push_back(i % 10 == 0 && i <= 30 ? i : kNone);  // every 10 s, then silence
  }
  hold_slow_channel(t_s, values);
  EXPECT_EQ(values[9], 0.0);
  EXPECT_EQ(values[29], 20.0);
  EXPECT_EQ(values[45], 30.0);
  EXPECT_TRUE(std::isnan(values[46]));
}

}  // namespace
}  // namespace soak::station
