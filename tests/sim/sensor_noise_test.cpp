// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/simulated_run.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;

/// Readings averaged over each segment of a run, less what is true at the mean temperature shown: deg/s or m/s².
std::vector<double> segment_mean_errors(const CampaignConfig& config, const SimulatedUnit& unit,
                                        const calib::Recording& recording, Sensor sensor) {
  std::vector<double> errors;
  const std::vector<double>& readings = recording.sensor[calib::index_of(sensor)];
  const auto count = static_cast<std::size_t>(config.rows_per_position);
  for (std::size_t row = 0; row < recording.rows(); ++row) {
    if (recording.position[row] < 0) continue;
    const std::vector<double> values(&readings[row], &readings[row] + count);
    const std::vector<double> temps_c(&recording.temp_c[row], &recording.temp_c[row] + count);
    const calib::Vector3 up = recording.positions[static_cast<std::size_t>(recording.position[row])].up;
    const calib::Vector3 force_mps2 = {9.80665 * up[0], 9.80665 * up[1], 9.80665 * up[2]};
    const double truth = ideal_reading(unit, sensor, test::mean_of(temps_c), force_mps2, {});
    const double error = test::mean_of(values) - truth - power_on_offset(config, unit, 1, sensor);
    errors.push_back(error * calib::printed_per_si(sensor));
    row += count - 1;
  }
  return errors;
}

// 30 units × 246 segments. The slowest of the three slow processes (10 % of the variance) hardly changes within a visit
// and little from one to the next: some 30 × 15 independent values of it, so that the RMS is known to about 1.5 %.
TEST(SensorNoise, GivesSegmentMeansTheDocumentedScatterWhateverTheNumberOfRows) {
  CampaignConfig config = test::shipped_config();
  config.thermometer.noise_sigma_c = 0.001;
  for (const int rows : {5, 50}) {
    config.rows_per_position = rows;
    std::vector<double> gyro_dps;
    std::vector<double> accel_mps2;
    for (int number = 1; number <= 30; ++number) {
      const SimulatedUnit unit = draw_unit(config, number);
      const calib::Recording recording = simulate_campaign_run(config, unit, 1);
      for (const double error : segment_mean_errors(config, unit, recording, Sensor::gyro_y)) gyro_dps.push_back(error);
      for (const double error : segment_mean_errors(config, unit, recording, Sensor::accel_z)) {
        accel_mps2.push_back(error);
      }
    }
    ASSERT_EQ(gyro_dps.size(), 30U * 246U);
    EXPECT_NEAR(test::rms_of(gyro_dps), 0.005, 0.06 * 0.005) << rows;
    EXPECT_NEAR(test::rms_of(accel_mps2), 0.003, 0.06 * 0.003) << rows;
  }
}

TEST(SensorNoise, HasSlowPartsThatRemainCorrelatedAcrossAPosition) {
  const CampaignConfig config = test::shipped_config();
  std::vector<double> products;
  std::vector<double> squares;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    SensorNoise noise(config, Sensor::gyro_x, seed);
    double first = 0.0;
    double second = 0.0;
    for (std::uint64_t i = 0; i < 30; ++i) first += noise.at(i, static_cast<double>(i)) / 30;
    for (std::uint64_t i = 30; i < 60; ++i) second += noise.at(i, static_cast<double>(i)) / 30;
    products.push_back(first * second);
    squares.push_back(first * first);
  }
  // Analytic: 0.3 Σᵢ cᵢ / Σᵢ vᵢ with vᵢ the variance of a 30 s mean and cᵢ the covariance of two adjacent ones, for
  // correlation times of 20, 200 and 2000 s, from the continuous formulas below.
  double variance = 0.0;
  double covariance = 0.0;
  for (const double tau_s : {20.0, 200.0, 2000.0}) {
    const double x = 30.0 / tau_s;
    variance += 2.0 / (x * x) * (x - 1.0 + std::exp(-x));
    covariance += std::pow((1.0 - std::exp(-x)) / x, 2);
  }
  // 4,000 pairs: standard error of the correlation 0.016.
  EXPECT_NEAR(test::mean_of(products) / test::mean_of(squares), 0.3 * covariance / variance, 0.05);
}

TEST(SensorNoise, KnowsTheVarianceOfTheMeanOfAGaussMarkovProcess) {
  EXPECT_DOUBLE_EQ(mean_variance_of_gauss_markov(50.0, 1.0, 1), 1.0);
  EXPECT_NEAR(mean_variance_of_gauss_markov(1e-3, 1.0, 40), 1.0 / 40, 1e-12);
  EXPECT_NEAR(mean_variance_of_gauss_markov(1e9, 1.0, 40), 1.0, 1e-6);
  // Sum of the geometric series in closed form.
  const int n = 30;
  const double r = std::exp(-1.0 / 20.0);
  const double closed = (n * (1 - r * r) - 2 * r * (1 - std::pow(r, n))) / (n * n * (1 - r) * (1 - r));
  EXPECT_NEAR(mean_variance_of_gauss_markov(20.0, 1.0, n), closed, 1e-12);
}

}  // namespace
}  // namespace soak::hal::sim
