// SPDX-License-Identifier: Apache-2.0
#include "station/lab/segment_capture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"

namespace soak::station {
namespace {

using calib::Sensor;

hal::ImuSample sample_at(double t_s) {
  hal::ImuSample sample;
  sample.t_s = t_s;
  return sample;
}

TEST(SegmentCapture, TakesItsSecondsOfDeviceTimeAfterTheFirstSample) {
  SegmentCapture capture(10.0);
  std::vector<double> taken_s;
  for (int i = 0; i < 400; ++i) {
    const hal::ImuSample sample = sample_at(5000.0 + 0.125 * i);
    if (capture.takes(sample)) taken_s.push_back(sample.t_s);
  }
  // 10 s from the second sample on, the last of them left to whatever comes next: 80 samples at 8 Hz.
  ASSERT_EQ(taken_s.size(), 80U);
  EXPECT_EQ(taken_s.front(), 5000.125);
  EXPECT_EQ(taken_s.back(), 5010.0);
  EXPECT_TRUE(capture.complete());
  EXPECT_FALSE(capture.broken());
  EXPECT_EQ(capture.samples(), 80U);
}

TEST(SegmentCapture, IsNotCompleteBeforeItsTime) {
  SegmentCapture capture(10.0);
  for (int i = 0; i <= 80; ++i) EXPECT_EQ(capture.takes(sample_at(0.125 * i)), i > 0);
  EXPECT_FALSE(capture.complete());
  EXPECT_FALSE(capture.takes(sample_at(10.125)));
  EXPECT_TRUE(capture.complete());
}

TEST(SegmentCapture, AGapOfMoreThanFiveSecondsBreaksIt) {
  SegmentCapture capture(100.0);
  for (const double t_s : {0.0, 1.0, 2.0, 7.0}) static_cast<void>(capture.takes(sample_at(t_s)));
  EXPECT_FALSE(capture.broken()) << "5 s are borne";
  EXPECT_EQ(capture.samples(), 3U);
  EXPECT_FALSE(capture.takes(sample_at(12.01)));
  EXPECT_TRUE(capture.broken());
  EXPECT_FALSE(capture.complete());
  EXPECT_FALSE(capture.takes(sample_at(12.02))) << "it has ended";
  EXPECT_EQ(capture.samples(), 3U);
}

TEST(SegmentCapture, AGapAcrossTheEndBreaksIt) {
  SegmentCapture capture(10.0);
  for (int i = 0; i <= 5; ++i) static_cast<void>(capture.takes(sample_at(i)));
  EXPECT_FALSE(capture.takes(sample_at(60.0)));
  EXPECT_TRUE(capture.broken());
  EXPECT_FALSE(capture.complete()) << "what was recorded is too short";
}

TEST(SegmentCapture, TheTemperatureOfARampChangesBySlopeTimesLength) {
  for (const double slope_kps : {0.01, -0.002, 0.0}) {
    SegmentCapture capture(100.0);
    for (int i = 0; i < 1100; ++i) {
      hal::ImuSample sample = sample_at(9000.0 + 0.1 * i);
      if (i % 10 == 1) sample.temp_c = static_cast<float>(-40.0 + slope_kps * 0.1 * i);
      static_cast<void>(capture.takes(sample));
    }
    EXPECT_TRUE(capture.complete());
    EXPECT_NEAR(capture.temp_change_c(), slope_kps * 100.0, 2e-3) << slope_kps;
  }
}

TEST(SegmentCapture, NoiseOfTheThermometerHardlyMovesTheTemperatureChange) {
  base::Random random(3);
  SegmentCapture capture(100.0);
  for (int i = 0; i < 1100; ++i) {
    hal::ImuSample sample = sample_at(0.1 * i);
    sample.temp_c = static_cast<float>(60.0 + 0.2 * random.gaussian());
    static_cast<void>(capture.takes(sample));
  }
  // Standard deviation of the slope times length: 0.2·√(12/1000) = 0.022 K.
  EXPECT_LE(std::abs(capture.temp_change_c()), 0.09);
}

TEST(SegmentCapture, ATemperatureChangeNeedsThreeReadings) {
  SegmentCapture capture(100.0);
  EXPECT_EQ(capture.temp_change_c(), 0.0);
  for (int i = 0; i < 4; ++i) {
    hal::ImuSample sample = sample_at(i);
    sample.temp_c = static_cast<float>(20 + i);
    EXPECT_EQ(capture.temp_change_c(), 0.0) << i;
    static_cast<void>(capture.takes(sample));
  }
  EXPECT_NEAR(capture.temp_change_c(), 2.0, 1e-6);
}

TEST(SegmentCapture, SpreadOfKnownSamples) {
  SegmentCapture capture(100.0);
  hal::ImuSample left_out = sample_at(0.0);
  left_out.rate_rps = {1e6F, 1e6F, 1e6F};
  static_cast<void>(capture.takes(left_out));
  // 2, 4, 4, 4, 5, 5, 7, 9: mean 5, squares about it 32, of a sample of eight 32/7.
  int i = 0;
  for (const float value : {2.0F, 4.0F, 4.0F, 4.0F, 5.0F, 5.0F, 7.0F, 9.0F}) {
    hal::ImuSample sample = sample_at(++i);
    sample.rate_rps = {value, -value, 1000.0F + value};
    sample.accel_mps2 = {10.0F * value, 0.25F, value};
    ASSERT_TRUE(capture.takes(sample));
  }
  const double sigma = std::sqrt(32.0 / 7.0);
  const auto expect = [&](Sensor sensor, double mean, double expected_sigma) {
    EXPECT_NEAR(capture.spread(sensor).mean, mean, 1e-9) << calib::name_of(sensor);
    EXPECT_NEAR(capture.spread(sensor).sigma, expected_sigma, 1e-9) << calib::name_of(sensor);
  };
  expect(Sensor::gyro_x, 5.0, sigma);
  expect(Sensor::gyro_y, -5.0, sigma);
  expect(Sensor::gyro_z, 1005.0, sigma);
  expect(Sensor::accel_x, 50.0, 10.0 * sigma);
  expect(Sensor::accel_y, 0.25, 0.0);
  expect(Sensor::accel_z, 5.0, sigma);
}

TEST(SegmentCapture, CountsClippedSamplesThatBelongToItOnly) {
  SegmentCapture capture(5.0);
  for (int i = 0; i < 20; ++i) {
    hal::ImuSample sample = sample_at(i);
    sample.clipped = i == 0 || i == 2 || i == 4 || i == 15;
    static_cast<void>(capture.takes(sample));
  }
  EXPECT_EQ(capture.samples(), 5U);
  EXPECT_EQ(capture.clipped(), 2U);
}

}  // namespace
}  // namespace soak::station
