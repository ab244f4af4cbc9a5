// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/inertial_unit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "hal/sim/lab/device_time.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// Allan variance of neighbouring clusters of `size` values.
double allan_variance(const std::vector<double>& values, std::size_t size) {
  std::vector<double> means;
  for (std::size_t start = 0; start + size <= values.size(); start += size) {
    double sum = 0.0;
    for (std::size_t i = 0; i < size; ++i) sum += values[start + i];
    means.push_back(sum / static_cast<double>(size));
  }
  double sum = 0.0;
  for (std::size_t i = 1; i < means.size(); ++i) sum += (means[i] - means[i - 1]) * (means[i] - means[i - 1]);
  return sum / (2.0 * static_cast<double>(means.size() - 1));
}

/// Noise of one sensor from a power-on, each fourth internal sample: 100 Hz.
std::vector<double> hundred_hertz(UnitNoise& noise, Sensor sensor, std::size_t count) {
  std::vector<double> values;
  for (std::uint64_t i = 1; i <= count; ++i) {
    noise.advance_to(4 * i);
    values.push_back(noise.at(sensor, 4 * i, 100.0));
  }
  return values;
}

// σ(τ) = N/√τ, with N = 2.25 °/√h = 0.0375 °/s/√Hz for gyros and 0.1 m/s/√h for accelerometers. Slow noise adds less
// than 0.5 % at 1 s; 3000 clusters know the deviation to 1.6 %.
TEST(UnitNoise, HasTheStatedRandomWalks) {
  const LabMagnitudes magnitudes = test::shipped_config().lab;
  UnitNoise noise(magnitudes);
  noise.start(7);
  const std::vector<double> gyro_rps = hundred_hertz(noise, Sensor::gyro_y, 300'000);
  EXPECT_NEAR(std::sqrt(allan_variance(gyro_rps, 100)), 2.25 / 60.0 * kRadPerDeg, 0.06 * 2.25 / 60.0 * kRadPerDeg);
  EXPECT_NEAR(std::sqrt(allan_variance(gyro_rps, 1)), 10.0 * 2.25 / 60.0 * kRadPerDeg, 0.2 * 2.25 / 60.0 * kRadPerDeg);
  noise.start(7);
  const std::vector<double> accel_mps2 = hundred_hertz(noise, Sensor::accel_x, 300'000);
  EXPECT_NEAR(std::sqrt(allan_variance(accel_mps2, 100)), 0.1 / 60.0, 0.06 * 0.1 / 60.0);
}

// A unit that puts out more averages less: the density stays.
TEST(UnitNoise, HasAVarianceInProportionToTheRate) {
  UnitNoise noise(test::shipped_config().lab);
  std::vector<double> at_100_hz;
  std::vector<double> at_400_hz;
  noise.start(7);
  for (std::uint64_t i = 0; i < 40'000; ++i) {
    noise.advance_to(i);
    at_100_hz.push_back(noise.at(Sensor::gyro_x, i, 100.0));
    at_400_hz.push_back(noise.at(Sensor::gyro_x, i, 400.0));
  }
  EXPECT_NEAR(test::rms_of(at_400_hz) / test::rms_of(at_100_hz), 2.0, 0.02);
}

// IEEE Std 952: bias instability B shows as a floor of 0.664 B in the Allan deviation. Here it is the maximum of the
// slow noise alone, averaged over 24 sequences of 3·10⁵ s; the longest clusters, 8192 s, are known to 3 %.
TEST(SlowNoise, ReachesTheFloorOfTheStatedBiasInstabilityAndNoMore) {
  const std::vector<double> times_s = test::shipped_config().lab.slow_correlation_times_s;
  const double instability = 10.0;  // °/h
  constexpr std::size_t kSequences = 24;
  std::vector<std::size_t> sizes;
  for (std::size_t size = 8; size <= 8192; size *= 2) sizes.push_back(size);
  std::vector<double> variances(sizes.size(), 0.0);
  for (std::size_t sequence = 0; sequence < kSequences; ++sequence) {
    SlowNoise noise(times_s, instability, 1.0);
    noise.start(3, sequence);
    std::vector<double> values;
    for (int i = 0; i < 300'000; ++i) {
      noise.step();
      values.push_back(noise.value());
    }
    for (std::size_t i = 0; i < sizes.size(); ++i) variances[i] += allan_variance(values, sizes[i]) / kSequences;
  }
  EXPECT_NEAR(std::sqrt(*std::max_element(variances.begin(), variances.end())), 6.64, 0.05 * 6.64);
  // Flat, as bias instability is, over two decades of averaging times.
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] < 16 || sizes[i] > 4096) continue;
    EXPECT_GT(std::sqrt(variances[i]), 0.8 * 6.64) << sizes[i];
  }
}

TEST(UnitNoise, IsAFunctionOfSeedAndSampleWhateverWasAskedBefore) {
  const LabMagnitudes magnitudes = test::shipped_config().lab;
  UnitNoise every(magnitudes);
  UnitNoise last_only(magnitudes);
  every.start(11);
  last_only.start(99);
  last_only.advance_to(12345);
  last_only.start(11);
  for (std::uint64_t i = 0; i <= 4001; ++i) {
    every.advance_to(i);
    (void)every.at(Sensor::gyro_x, i, 400.0);
  }
  last_only.advance_to(4001);
  for (const Sensor sensor : calib::kSensors) {
    EXPECT_EQ(every.at(sensor, 4001, 100.0), last_only.at(sensor, 4001, 100.0));
  }
  last_only.start(12);
  last_only.advance_to(4001);
  EXPECT_NE(every.at(Sensor::gyro_x, 4001, 100.0), last_only.at(Sensor::gyro_x, 4001, 100.0));
}

TEST(UnitNoise, DiffersFromSensorToSensor) {
  UnitNoise noise(test::shipped_config().lab);
  noise.start(5);
  std::vector<double> products;
  std::vector<double> squares;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    const double x = noise.at(Sensor::gyro_x, i, 100.0);
    products.push_back(x * noise.at(Sensor::gyro_y, i, 100.0));
    squares.push_back(x * x);
  }
  EXPECT_LT(std::abs(test::mean_of(products) / test::mean_of(squares)), 0.04);  // four standard errors
}

}  // namespace
}  // namespace soak::hal::sim
