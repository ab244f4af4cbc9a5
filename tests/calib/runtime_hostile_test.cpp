// SPDX-License-Identifier: Apache-2.0
// Files whose check sum is right and whose content is not: nothing may be read outside them (the sanitizers watch), and
// what is accepted must be evaluated without a crash.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "base/random.h"
#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/long_tests.h"

namespace soak::calib {
namespace {

using namespace samples;

const float kHostileTemperatures[] = {-30.0F,
                                      -29.9F,
                                      0.0F,
                                      20.0F,
                                      69.99F,
                                      70.0F,
                                      1e9F,
                                      -1e9F,
                                      1e-40F,
                                      std::numeric_limits<float>::quiet_NaN(),
                                      std::numeric_limits<float>::infinity()};

void evaluate_everything(const soak_cal& cal) {
  const float raw[6] = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};
  for (const float temp_c : kHostileTemperatures) {
    for (int sensor = 0; sensor < SOAK_SENSORS; ++sensor) {
      float a = 0.0F;
      float b = 0.0F;
      const soak_status bias = soak_bias(&cal, sensor, temp_c, &a);
      EXPECT_EQ(std::isfinite(a), bias == SOAK_OK || bias == SOAK_CLAMPED);
      const soak_status scale = soak_scale_ppm(&cal, sensor, temp_c, &b);
      EXPECT_EQ(std::isfinite(b), scale == SOAK_OK || scale == SOAK_CLAMPED);
      EXPECT_GE(soak_uncertainty(&cal, sensor, temp_c, &a, &b), SOAK_OK);
      EXPECT_GE(soak_temp_range(&cal, sensor, &a, &b), SOAK_OK);
    }
    float out[6];
    std::uint32_t flags = 0;
    const soak_status status = soak_apply(&cal, temp_c, raw, out, &flags);
    EXPECT_EQ(status == SOAK_OK, flags == 0U);
    for (const float value : out) EXPECT_TRUE(std::isfinite(value));
  }
}

void mutate(base::Bytes& bytes, base::Random& random) {
  static constexpr std::uint32_t kWords[] = {0,          1,          0x7F800000, 0x7FC00000, 0xFF7FFFFF, 0x00000001,
                                             0x80000000, 0xFFFFFFFF, 0x0000FFFF, 0x00010001, 0x3F800000, 0x461C4000};
  const std::size_t size = bytes.size();
  const int changes = 1 + static_cast<int>(random.uniform(0.0, 4.0));
  for (int i = 0; i < changes; ++i) {
    const auto at = static_cast<std::size_t>(random.uniform(8.0, static_cast<double>(size - 4)));
    if (random.uniform() < 0.5) {
      bytes[at] = static_cast<std::uint8_t>(random.next());
    } else {
      put(bytes, std::max<std::size_t>(at / 4 * 4, 16), kWords[random.next() % std::size(kWords)]);
    }
  }
  if (random.uniform() < 0.1) bytes.resize(28 + random.next() % (size - 28));
  seal(bytes);
}

TEST(RuntimeHostile, MutatedFilesWithAGoodCheckSumNeverCrash) {
  SOAK_LONG_TEST();
  const base::Bytes originals[] = {*encode(golden_fis()), *encode(golden_mixed()), *encode(with_bias(table(0.1)))};
  base::Random random(11);
  int accepted = 0;
  constexpr int kFiles = 20000;
  for (int i = 0; i < kFiles; ++i) {
    base::Bytes bytes = originals[random.next() % std::size(originals)];
    mutate(bytes, random);
    // exactly as large as the file, so that a sanitizer sees the first byte read beyond it
    const auto exact = std::make_unique<std::uint8_t[]>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), exact.get());
    soak_cal cal;
    const soak_status status = soak_load(&cal, exact.get(), bytes.size());
    evaluate_everything(cal);
    const auto read = decode({exact.get(), bytes.size()});
    if (status != SOAK_OK) {
      ASSERT_FALSE(read);
      continue;
    }
    ++accepted;
    if (!read) continue;  // only decode looks into accepted terms
    for (const SensorCalibration& sensor : read->sensors) (void)evaluate(sensor.bias, 20.0);
    if (accepted % 50 == 0) (void)encode(*read);
  }
  EXPECT_GT(accepted, kFiles / 20);  // the test sees both outcomes
  EXPECT_LT(accepted, kFiles);
}

TEST(RuntimeHostile, RandomBytesUnderAValidHeadNeverCrash) {
  base::Random random(12);
  const base::Bytes head = *encode(with_bias(table(0.1)));
  for (int i = 0; i < 20000; ++i) {
    base::Bytes bytes(head.begin(), head.begin() + 24);
    bytes.resize(28 + 4 * (random.next() % 64));
    for (std::size_t at = 24; at < bytes.size(); ++at) {
      bytes[at] = static_cast<std::uint8_t>(random.next() % (random.uniform() < 0.5 ? 4 : 256));
    }
    put(bytes, 20, static_cast<std::uint32_t>(1 + random.next() % 8));
    seal(bytes);
    soak_cal cal;
    ASSERT_NE(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
    ASSERT_FALSE(decode(bytes));
  }
}

}  // namespace
}  // namespace soak::calib
