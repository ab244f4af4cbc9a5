// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "calib/vocabulary/segment.h"

namespace soak::calib {

// Segments that must be the same to the last bit: described in parts and as a whole, stored and read back.

inline void expect_same(const std::array<SensorStatistics, kSensorCount>& a,
                        const std::array<SensorStatistics, kSensorCount>& b) {
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    EXPECT_EQ(a[s].count, b[s].count);
    for (const auto member :
         {&SensorStatistics::mean, &SensorStatistics::variance, &SensorStatistics::standard_error}) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(a[s].*member), std::bit_cast<std::uint64_t>(b[s].*member));
    }
  }
}

inline void expect_same(const Block& a, const Block& b) {
  EXPECT_EQ(a.t_s, b.t_s);
  EXPECT_EQ(a.duration_s, b.duration_s);
  EXPECT_EQ(a.temp_c, b.temp_c);
  EXPECT_EQ(a.temp_rate_kpmin, b.temp_rate_kpmin);
  EXPECT_EQ(a.sensor_temp_c, b.sensor_temp_c);
  expect_same(a.sensor, b.sensor);
}

inline void expect_same(const Segment& a, const Segment& b) {
  EXPECT_EQ(a.key, b.key);
  EXPECT_EQ(a.phase, b.phase);
  EXPECT_EQ(a.sweep, b.sweep);
  EXPECT_EQ(a.plateau_c, b.plateau_c);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.t_start_s, b.t_start_s);
  EXPECT_EQ(a.t_end_s, b.t_end_s);
  EXPECT_EQ(a.temp_c, b.temp_c);
  EXPECT_EQ(a.temp_rate_kpmin, b.temp_rate_kpmin);
  EXPECT_EQ(a.sensor_temp_c, b.sensor_temp_c);
  expect_same(a.sensor, b.sensor);
  EXPECT_EQ(a.findings, b.findings);
  ASSERT_EQ(a.blocks.size(), b.blocks.size());
  for (std::size_t i = 0; i < a.blocks.size(); ++i) expect_same(a.blocks[i], b.blocks[i]);
}

}  // namespace soak::calib
